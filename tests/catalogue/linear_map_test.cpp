// The closed forms of the cases, compared step by step with the recurrences that they stand for.
#include "evenstep/catalogue/linear_map.h"

#include <cmath>

#include "catch.h"
#include "chain.h"

using namespace evenstep;
using namespace evenstep::internal;
using Real = LinearMap::Real;

namespace {

constexpr Method kMethods[] = {Method::symplectic_euler, Method::velocity_verlet,   Method::rk4,
                               Method::implicit_euler,   Method::implicit_midpoint, Method::vertex_block_descent};

/// One step of the method as its definition reads, from the acceleration -w2 x - d v.
LinearMap::State step(Method method, Real w2, Real d, Real h, LinearMap::State z) {
  const auto rate = [&](LinearMap::State s) { return LinearMap::State{s.v, -w2 * s.x - d * s.v}; };
  const auto moved = [](LinearMap::State s, Real by, LinearMap::State r) {
    return LinearMap::State{s.x + by * r.x, s.v + by * r.v};
  };
  switch (method) {
    case Method::symplectic_euler: {
      const Real v = (1 - h * d) * z.v - h * w2 * z.x;
      return {z.x + h * v, v};
    }
    case Method::velocity_verlet: {
      const Real half = z.v - h * w2 * z.x / 2, x = z.x + h * half;
      return {x, half - h * w2 * x / 2};
    }
    case Method::rk4: {
      const auto k1 = rate(z), k2 = rate(moved(z, h / 2, k1)), k3 = rate(moved(z, h / 2, k2)), k4 = rate(moved(z, h, k3));
      return {z.x + h / 6 * (k1.x + 2 * k2.x + 2 * k3.x + k4.x), z.v + h / 6 * (k1.v + 2 * k2.v + 2 * k3.v + k4.v)};
    }
    case Method::implicit_euler:
    case Method::vertex_block_descent: {  // x' = x + h v', v' = v - h w2 x' - h d v'
      const Real v = (z.v - h * w2 * z.x) / (1 + h * d + h * h * w2);
      return {z.x + h * v, v};
    }
    case Method::implicit_midpoint: {  // with the mean of both ends
      const Real v = (z.v * (1 - h * d / 2 - h * h * w2 / 4) - h * w2 * z.x) / (1 + h * d / 2 + h * h * w2 / 4);
      return {z.x + h * (z.v + v) / 2, v};
    }
  }
  return {};
}

}  // namespace

TEST_CASE("The power of a method's matrix is its recurrence, over seven decades of the step and with any damping") {
  const Real w = 37;
  for (const Method method : kMethods) {
    for (const Real z : {1e-4L, 1e-3L, 0.01L, 0.1L, 0.5L, 1.0L, 1.9L, 1.99L, 2.5L, 30.0L, 1000.0L}) {
      for (const Real ratio : {0.0L, 0.001L, 0.3L, 3.0L}) {
        if (method == Method::velocity_verlet && ratio > 0) continue;  // there is no closed form for that here
        const Real h = z / w, d = 2 * ratio * w;
        const LinearMap map = linear_map(method, w * w, d, h);
        CHECK(std::abs(map.determinant - (map.a * map.d - map.b * map.c)) <=
              1e-15L * (std::abs(map.a * map.d) + std::abs(map.b * map.c)));
        LinearMap::State exact{1, 0.3L * w};
        // Each step loses a few units in the 19th digit, relative to the largest so far.
        Real largest = 1 + 0.3L;
        for (int n = 1; n <= 300 && largest < 1e300L; ++n) {
          exact = step(method, w * w, d, h, exact);
          largest = std::max({largest, std::abs(exact.x), std::abs(exact.v) / w});
          const LinearMap::State power = map.power(n, {1, 0.3L * w});
          INFO(static_cast<int>(method) << " z " << static_cast<double>(z) << " ratio " << static_cast<double>(ratio)
                                        << " n " << n);
          REQUIRE(std::abs(power.x - exact.x) <= 1e-13L * largest);
          REQUIRE(std::abs(power.v - exact.v) <= 1e-13L * largest * w);
        }
      }
    }
  }
}

TEST_CASE("Where float holds every constant, the problem that float solves is the one given") {
  for (const Method method : kMethods) {
    if (method == Method::rk4) continue;  // h / 6 is never a float
    // With h = 2^-10 and k / m = 2^20 or the like, all products are powers of two.
    const LinearMap given = linear_map(method, std::pow(2.0L, 18), 0, std::pow(2.0L, -10));
    const LinearMap rounded = float_linear_map(method, 256, std::pow(2.0, -10), std::pow(2.0, -10));
    INFO(name_of(method));
    for (const auto& [a, b] :
         {std::pair{given.a, rounded.a}, {given.b, rounded.b}, {given.c, rounded.c}, {given.d, rounded.d}})
      CHECK(std::abs(a - b) <= 1e-18L * std::abs(a));
    CHECK(std::abs(given.determinant - rounded.determinant) <= 1e-18L);
  }
}

TEST_CASE("The problem that float solves is another one by the rounding of its constants, and no more") {
  for (const Method method : kMethods) {
    for (const double z : {0.01, 0.3, 1.0, 1.9}) {
      const double mass = 1e-3, h = 1e-3, stiffness = mass * z * z / (h * h);
      const LinearMap given = linear_map(method, static_cast<Real>(stiffness) / mass, 0, h);
      const LinearMap rounded = float_linear_map(method, stiffness, mass, h);
      INFO(name_of(method) << " z " << z);
      const Real apart = std::abs(given.b - rounded.b) / h + std::abs(given.c - rounded.c) * mass / (h * stiffness);
      CHECK(apart > 1e-10L);
      CHECK(apart < 5e-7L);
      CHECK(std::abs(rounded.determinant - (rounded.a * rounded.d - rounded.b * rounded.c)) <= 1e-17L);
    }
  }
}

TEST_CASE("Symplectic Euler turns by the angle whose half has the sine w h / 2, down to the smallest step") {
  for (const Real z : {1e-9L, 1e-6L, 1e-3L, 0.1L, 1.0L, 1.99L}) {
    const Real angle = linear_map(Method::symplectic_euler, 1, 0, z).angle();
    CHECK(std::abs(std::sin(angle / 2) - z / 2) <= 1e-17L * z);
    CHECK(std::abs(linear_map(Method::velocity_verlet, 1, 0, z).angle() - angle) <= 1e-16L * angle);
  }
}

TEST_CASE("The conserved form is multiplied by the determinant in every step, and bounds the excursion") {
  for (const Method method : kMethods) {
    for (const Real z : {0.01L, 0.3L, 1.0L, 1.9L}) {
      const LinearMap map = linear_map(method, 1, 0, z);
      REQUIRE(map.oscillates());
      LinearMap::State state{1, 0};
      const Real first = map.invariant(state), reach = map.amplitude(state);
      Real furthest = 1;
      for (int n = 1; n <= 2000; ++n) {
        state = map.times(state);
        furthest = std::max(furthest, std::abs(state.x));
        REQUIRE(map.invariant(state) == Approx(static_cast<double>(first * std::pow(map.determinant, n))).epsilon(1e-9));
      }
      CHECK(furthest <= reach * (1 + 1e-12L));
      if (map.determinant == 1 && z < 0.5L) CHECK(furthest >= 0.99L * reach);
    }
  }
}

TEST_CASE("The exact flow composes with itself, on every side of critical damping") {
  for (const Real ratio : {0.0L, 0.5L, 1.0L, 2.0L, 50.0L}) {
    const LinearMap half = exact_map(9, 6 * ratio, 0.01L), whole = exact_map(9, 6 * ratio, 0.02L);
    const LinearMap::State twice = half.times(half.times({1, 2})), once = whole.times({1, 2});
    CHECK(std::abs(twice.x - once.x) <= 1e-17L);
    CHECK(std::abs(twice.v - once.v) <= 1e-16L);
  }
}

TEST_CASE("The modes of a chain solve its equations: -w2 u = (k / m) (u[i-1] - 2 u[i] + u[i+1])") {
  const double k = 50, m = 1.25e-4;
  for (const int n : {1, 2, 16, 64}) {
    for (int p = 1; p <= n; ++p) {
      const double w2 = chain_w2_per_s2(n, p, k, m);
      const auto mode = [&](int i) { return std::sin(M_PI * p * i / (n + 1)); };
      for (int i = 1; i <= n; ++i)
        REQUIRE(std::abs(w2 * mode(i) + k / m * (mode(i - 1) - 2 * mode(i) + mode(i + 1))) <= 1e-12 * 4 * k / m);
    }
  }
}
