// Axes of symmetric matrices, and contacts made softer along them.
#include <catch2/catch.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "evenstep/device/renderer.h"

using namespace evenstep;

namespace {

constexpr double kEpsilon = 0x1p-52;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(const glm::dvec3& v) { return std::sqrt(dot(v, v)); }
glm::dvec3 cross(const glm::dvec3& a, const glm::dvec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
bool same_bits(const Symmetric& a, const Symmetric& b) {
  const auto bits = [](const Symmetric& k) { return std::bit_cast<std::array<std::uint64_t, 6>>(k); };
  return bits(a) == bits(b);
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double uniform(double from, double to) { return from + (to - from) * (static_cast<double>(bits_() >> 11) * 0x1p-53); }
  glm::dvec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  /// Three orthonormal directions.
  std::array<glm::dvec3, 3> basis() {
    for (;;) {
      const glm::dvec3 a = vector(1), b = vector(1);
      const glm::dvec3 c = cross(a, b);
      if (length(c) < 0.1) continue;
      return {a / length(a), c / length(c), cross(c, a) / (length(c) * length(a))};
    }
  }

 private:
  std::mt19937_64 bits_;
};

Symmetric matrix_of(const std::array<glm::dvec3, 3>& axes, const std::array<double, 3>& values) {
  Symmetric k;
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::dvec3& n = axes[i];
    const double s = values[i];
    k = {k.xx + s * n.x * n.x, k.yy + s * n.y * n.y, k.zz + s * n.z * n.z,
         k.xy + s * n.x * n.y, k.xz + s * n.x * n.z, k.yz + s * n.y * n.z};
  }
  return k;
}

/// Apart, nearly equal, equal, zero, of either sign, over sixteen decades.
std::array<double, 3> some_values(Random& random, int i) {
  const double size = std::pow(10, random.uniform(-8, 8));
  switch (i % 5) {
    case 0:
      return {size, random.uniform(0, size), random.uniform(0, size)};
    case 1:
      return {size, size * (1 + 1e-12), random.uniform(0, size)};
    case 2:
      return {size, size, size};
    case 3:
      return {size, 0, 0};
    default:
      return {size, -random.uniform(0, size), random.uniform(-size, size) * 1e-9};
  }
}

}  // namespace

TEST_CASE("the axes of a symmetric matrix are orthonormal and give it back, 50,000 random ones") {
  Random random(1);
  for (int i = 0; i < 50'000; ++i) {
    std::array<double, 3> values = some_values(random, i);
    const Symmetric k = matrix_of(random.basis(), values);
    Axes found = axes_of(k);
    const double size = std::max(std::abs(values[0]), std::abs(values[1]));
    for (std::size_t a = 0; a < 3; ++a) {
      // Up to twelve sweeps of three rotations, each of a few roundings.
      for (std::size_t b = 0; b < 3; ++b)
        REQUIRE(std::abs(dot(found.axes[a], found.axes[b]) - (a == b ? 1 : 0)) <= 32 * kEpsilon);
      REQUIRE(length(k * found.axes[a] - found.axes[a] * found.values[a]) <= 32 * kEpsilon * size);
    }
    REQUIRE(largest_value(found) == *std::max_element(found.values.begin(), found.values.end()));
    std::sort(values.begin(), values.end());
    std::sort(found.values.begin(), found.values.end());
    for (std::size_t a = 0; a < 3; ++a) REQUIRE(std::abs(values[a] - found.values[a]) <= 32 * kEpsilon * size);
  }
}

TEST_CASE("a diagonal matrix is its own answer, and what is not finite has no values") {
  const Axes axes = axes_of({3, -2, 7, 0, 0, 0});
  CHECK(axes.values == std::array<double, 3>{3, -2, 7});
  CHECK(axes.axes[1] == glm::dvec3(0, 1, 0));
  CHECK(largest_value(axes_of(Symmetric{})) == 0);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity}) {
    CHECK_FALSE(std::isfinite(largest_value(axes_of({1, 2, 3, bad, 0, 0}))));
    CHECK_FALSE(std::isfinite(largest_value(axes_of({bad, 2, 3, 1, 0, 0}))));
  }
}

TEST_CASE(
    "a softened contact keeps its axes and what is below the cap, what is above becomes the cap, force in proportion") {
  Random random(2);
  int softer = 0;
  for (int i = 0; i < 50'000; ++i) {
    const std::array<glm::dvec3, 3> axes = random.basis();
    const double size = std::pow(10, random.uniform(0, 5));
    const std::array<double, 3> values{random.uniform(0, size), random.uniform(0, size), random.uniform(0, size)};
    const double cap = random.uniform(0.05, 1.2) * size;
    ContactRecord record{
        random.vector(10), random.vector(0.1), matrix_of(axes, values), axes[0], random.uniform(-1, 1), true, {}};
    const Softened soft = softened(record, cap);
    const double stiffest = *std::max_element(values.begin(), values.end());
    REQUIRE(soft.stiffest_N_per_m == Approx(stiffest).epsilon(1e-12));
    for (std::size_t a = 0; a < 3; ++a) {
      const double expected = std::min(values[a], cap);
      // Roundings of the values, and of a force of 10 N under a share that is as exact as the values are.
      REQUIRE(length(soft.record.stiffness_N_per_m * axes[a] - axes[a] * expected) <= 100 * kEpsilon * size);
      const double share = values[a] > cap ? cap / values[a] : 1;
      REQUIRE(dot(soft.record.force_N, axes[a]) == Approx(dot(record.force_N, axes[a]) * share).margin(1e-9));
    }
    REQUIRE(largest_value(axes_of(soft.record.stiffness_N_per_m)) <= std::min(cap, stiffest) * (1 + 1e-12));
    const auto [x, y, z] = axes_of(soft.record.stiffness_N_per_m).values;
    REQUIRE(std::min({x, y, z}) >= -100 * kEpsilon * size);
    REQUIRE(soft.record.gap_m == record.gap_m);
    REQUIRE(soft.record.tool_m == record.tool_m);
    softer += stiffest > cap;
  }
  CHECK((softer > 10'000 && softer < 49'000));
}

TEST_CASE("a contact that is soft enough passes bit for bit, and so does one that is not a number") {
  Random random(3);
  for (int i = 0; i < 10'000; ++i) {
    const Symmetric k =
        matrix_of(random.basis(), {random.uniform(0, 900), random.uniform(0, 900), random.uniform(-900, 900)});
    const ContactRecord record{random.vector(10), random.vector(0.1), k, {}, 0, false, {}};
    for (const double cap : {901.0, kInfinity}) {
      const Softened soft = softened(record, cap);
      REQUIRE(same_bits(soft.record.stiffness_N_per_m, k));
      REQUIRE(soft.record.force_N == record.force_N);
    }
  }
  ContactRecord broken;
  broken.stiffness_N_per_m = {std::numeric_limits<double>::quiet_NaN(), 1e9, 0, 0, 0, 0};
  broken.force_N = {1, 2, 3};
  CHECK(same_bits(softened(broken, 10).record.stiffness_N_per_m, broken.stiffness_N_per_m));
  CHECK(softened(broken, 10).record.force_N == broken.force_N);
}

TEST_CASE("a wall under a cap is a softer wall at the same place, before and in the touch") {
  Random random(4);
  for (int i = 0; i < 20'000; ++i) {
    const std::array<glm::dvec3, 3> axes = random.basis();
    const double stiffness = random.uniform(1000, 5000), cap = random.uniform(100, 900), gap_m = random.uniform(-0.01, 0.01);
    const ContactRecord wall{axes[0] * (stiffness * std::max(0.0, -gap_m)),
                             axes[0] * gap_m,
                             matrix_of(axes, {stiffness, 0, 0}),
                             axes[0],
                             gap_m,
                             true,
                             {}};
    const AffineContact contact = affine_contact(softened(wall, cap).record, true);
    const double depth_m = random.uniform(-0.01, 0.01);
    const glm::dvec3 force_N = LocalRenderer(1).force_N(contact, Duration{0}, axes[0] * -depth_m);
    REQUIRE(length(force_N - axes[0] * (cap * std::max(0.0, depth_m))) <= 1e-12 * stiffness);
  }
}
