
#include <cmath>

#include "catch.h"
#include "evenstep/device/stiffness_laws.h"

using namespace evenstep;

namespace {

/// 30 Hz, 11.1 ms of visualization, 15 steps and a 1 kHz device: L = 15.064 ms with linear emission.
LoopDelays reference(double device_s = 0) { return {0.0155644, 1e-3, device_s}; }

}  // namespace

TEST_CASE("at alpha* nothing is rendered beside the spring, whatever its stiffness and the delays") {
  for (const double late : {0.002, 0.0053, 0.0155644, 0.0238, 0.1}) {
    for (const double h : {1.25e-4, 1e-3, 2e-3}) {
      for (const double d : {0.0, 1e-3, 2e-3}) {
        const LoopDelays loop{late, h, d};
        const std::optional<double> star = alpha_star(loop);
        REQUIRE(star);
        CHECK(*star > 1);
        for (const double stiffness : {50.0, 300.0, 5000.0}) {
          CHECK(rendered_damping(stiffness, *star, loop) == Approx(0).margin(1e-13 * stiffness));
          CHECK(rendered_damping(stiffness, 0.99 * *star, loop) < 0);
          CHECK(rendered_damping(stiffness, 1.01 * *star, loop) > 0);
        }
      }
    }
  }
}

TEST_CASE("the laws at the reference timing") {
  CHECK(*alpha_star(reference()) == Approx(1.0332).margin(1e-4));
  CHECK(*alpha_star(reference(1e-3)) == Approx(1.0996).margin(1e-4));
  CHECK(*alpha_star(reference(2e-3)) == Approx(1.1660).margin(1e-4));
  CHECK(rendered_damping(300, 0, reference()) == Approx(-4.67).margin(0.01));
  CHECK(damping_limit_N_per_m(0, reference(), 1) == Approx(64.25).margin(0.01));
  CHECK(damping_limit_N_per_m(1, reference(), 1) == Approx(2000));
  CHECK(damping_limit_N_per_m(0.9, reference(), 1) == Approx(498).margin(1));
  CHECK(overshoot_limit_N_per_m(1.1, reference(), 0.2) == Approx(3735).margin(1));
  CHECK(automatic_alpha(reference(), std::nullopt) == Approx(1.1032).margin(1e-4));
  CHECK(automatic_alpha(reference(), Plant{0.2, 1}) == automatic_alpha(reference(), std::nullopt));
  // Measured: at 2 N s/m the loop is stable up to 5452 N/m with alpha 1.1 and up to 3998 N/m with alpha 1; at 5 N s/m up to
  // 7766 and 10,004 N/m.
  CHECK(automatic_alpha(reference(), Plant{0.2, 2}) == automatic_alpha(reference(), std::nullopt));
  CHECK(automatic_alpha(reference(), Plant{0.2, 5}) == 1);
}

TEST_CASE("the largest stiffness is where the rendered damping takes away all of the plant's") {
  const Plant plant{0.2, 1};
  for (double alpha = 0; alpha < 1.03; alpha += 0.05) {
    for (const double d : {0.0, 1e-3}) {
      const double limit = largest_stiffness_N_per_m(alpha, reference(d), plant);
      CHECK(rendered_damping(limit, alpha, reference(d)) == Approx(-plant.damping_N_s_per_m).epsilon(1e-12));
    }
  }
  // Above alpha* the overshoot sets the limit, not the damping.
  CHECK(std::isinf(damping_limit_N_per_m(1.1, reference(), 1)));
  CHECK(largest_stiffness_N_per_m(1.1, reference(), plant) == overshoot_limit_N_per_m(1.1, reference(), 0.2));
}

TEST_CASE("springs of the device's own are held for its own period and what is steeper for the loop's") {
  // Measured (docs/forces/stiffness.md) within 1 %: 7980 to 8050; 2725 to 2749, 3480 to 3510 and 4978 to 5022 N/m.
  const auto with_own = [](double own_N_per_m) {
    LoopDelays loop = reference();
    loop.own_N_per_m = own_N_per_m;
    loop.own_period_s = 0.25e-3;
    return loop;
  };
  CHECK(damping_limit_N_per_m(1, with_own(1e5), 1) == Approx(8000));
  for (const auto& [own, limit] : {std::pair{1000.0, 2750.0}, {2000.0, 3500.0}, {4000.0, 5000.0}})
    CHECK(damping_limit_N_per_m(1, with_own(own), 1) == Approx(limit));
  const Plant plant{0.2, 1};
  for (const double own : {10.0, 300.0, 1000.0, 1e5}) {
    const LoopDelays loop = with_own(own);
    for (double alpha = 0; alpha < 1.005; alpha += 0.05) {
      const double limit = largest_stiffness_N_per_m(alpha, loop, plant);
      CHECK(limit >= largest_stiffness_N_per_m(alpha, reference(), plant));
      CHECK(rendered_damping(limit, alpha, loop) == Approx(-plant.damping_N_s_per_m).epsilon(1e-12));
    }
  }
  const double star = *alpha_star(with_own(1000));
  CHECK(star == Approx(1.0081).margin(1e-4));
  CHECK(rendered_damping(900, star, with_own(1000)) == Approx(0).margin(1e-10));
  CHECK(rendered_damping(2000, star, with_own(1000)) < -0.3);
}

TEST_CASE("without a latency there is no alpha* and nothing to round up") {
  const LoopDelays none{0.5e-3, 1e-3, 0};
  CHECK_FALSE(alpha_star(none));
  CHECK(automatic_alpha(none, Plant{0.2, 1}) == 1);
  // With half a tick of latency alpha* would be 2, and with a millionth of a tick more than any renderer accepts.
  CHECK(automatic_alpha({1e-3, 1e-3, 0}, std::nullopt) == Approx(2.07));
  CHECK(automatic_alpha({0.5e-3 + 1e-9, 1e-3, 0}, std::nullopt) == 4);
}

TEST_CASE("an automatic alpha is 1 above 3 N s/m, where the damping carries 1.6 times what the overshoot does") {
  // The damping at which both are equal is 1.6 K_overshoot h / 2, at the reference timing and 0.2 kg. Straight lines through
  // what was measured at 2 and 5 N s/m (above) cross at 3.2 N s/m: there the better of the two alphas changes.
  const double alpha = automatic_alpha(reference(), std::nullopt);
  const double edge_N_s_per_m = 1.6 * overshoot_limit_N_per_m(alpha, reference(), 0.2) * 1e-3 / 2;
  CHECK(edge_N_s_per_m == Approx(2.97).margin(0.01));
  CHECK(automatic_alpha(reference(), Plant{0.2, 0.99 * edge_N_s_per_m}) == alpha);
  CHECK(automatic_alpha(reference(), Plant{0.2, 1.01 * edge_N_s_per_m}) == 1);
  // With twice the mass the overshoot limit is twice as stiff.
  CHECK(automatic_alpha(reference(), Plant{0.4, 1.98 * edge_N_s_per_m}) == alpha);
  CHECK(automatic_alpha(reference(), Plant{0.4, 2.02 * edge_N_s_per_m}) == 1);
}
