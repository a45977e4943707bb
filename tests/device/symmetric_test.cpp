// Axes of symmetric matrices, and contacts made softer along them.
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <glm/matrix.hpp>
#include <limits>
#include <random>

#include "cases.h"
#include "catch.h"
#include "evenstep/device/renderer.h"
#include "units.h"
#include "vectors.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

bool same_bits(const Symmetric& a, const Symmetric& b) {
  const auto bits = [](const Symmetric& k) { return std::bit_cast<std::array<std::uint64_t, 6>>(k); };
  return bits(a) == bits(b);
}

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

/// Three values that are far apart, nearly equal, equal or zero, of either sign, over sixteen decades.
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

/// The eigenvalues, largest first, computed in an independent way: as the roots of the characteristic polynomial by the
/// cosine (O. K. Smith, Eigenvalues of a symmetric 3 x 3 matrix, CACM 4, 1961). Where two are nearly equal, half of the
/// digits are lost.
std::array<double, 3> values_by_cosine(const Symmetric& k) {
  const double mean = (k.xx + k.yy + k.zz) / 3;
  const double a = k.xx - mean, b = k.yy - mean, c = k.zz - mean;
  const double spread = std::sqrt((a * a + b * b + c * c + 2 * (k.xy * k.xy + k.xz * k.xz + k.yz * k.yz)) / 6);
  if (spread == 0) return {mean, mean, mean};
  const double det = a * (b * c - k.yz * k.yz) - k.xy * (k.xy * c - k.yz * k.xz) + k.xz * (k.xy * k.yz - b * k.xz);
  const double third = std::acos(std::clamp(det / (2 * spread * spread * spread), -1.0, 1.0)) / 3;
  const double turn = 2 * std::acos(-1.0) / 3;
  const double most = mean + 2 * spread * std::cos(third), least = mean + 2 * spread * std::cos(third + turn);
  return {most, 3 * mean - most - least, least};
}

/// R k R' for the rotation whose columns are `to`.
Symmetric turned(const Symmetric& k, const std::array<glm::dvec3, 3>& to) {
  const glm::dvec3 columns[3] = {{k.xx, k.xy, k.xz}, {k.xy, k.yy, k.yz}, {k.xz, k.yz, k.zz}};
  glm::dmat3 sum(0);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      sum += glm::outerProduct(to[static_cast<std::size_t>(i)], to[static_cast<std::size_t>(j)]) * columns[j][i];
  return {sum[0][0], sum[1][1], sum[2][2], sum[1][0], sum[2][0], sum[2][1]};
}
glm::dvec3 turned(const glm::dvec3& v, const std::array<glm::dvec3, 3>& to) {
  return to[0] * v.x + to[1] * v.y + to[2] * v.z;
}

double most_apart(const Symmetric& a, const Symmetric& b) {
  return std::max({std::abs(a.xx - b.xx), std::abs(a.yy - b.yy), std::abs(a.zz - b.zz), std::abs(a.xy - b.xy),
                   std::abs(a.xz - b.xz), std::abs(a.yz - b.yz)});
}

double quadratic(const Symmetric& k, const glm::dvec3& v) { return dot(v, k * v); }

}  // namespace

TEST_CASE("the axes of a symmetric matrix are orthonormal and give it back, 50,000 random ones") {
  Random random(1);
  for (int i = 0; i < evenstep::testing::cases(50'000); ++i) {
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
  for (int i = 0; i < evenstep::testing::cases(50'000); ++i) {
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
      // Room for roundings of the values, and of a force of 10 N times a share that is as exact as the values are.
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
  CHECK((softer > evenstep::testing::cases(10'000) && softer < evenstep::testing::cases(49'000)));
}

TEST_CASE("a contact that is soft enough passes bit for bit, and so does one that is not a number") {
  Random random(3);
  for (int i = 0; i < evenstep::testing::cases(10'000); ++i) {
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
  for (int i = 0; i < evenstep::testing::cases(20'000); ++i) {
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

TEST_CASE("the values and the cap are those of an independent solution of the characteristic polynomial, 50,000 matrices") {
  Random random(5);
  for (int i = 0; i < evenstep::testing::cases(50'000); ++i) {
    const double size = std::pow(10, random.uniform(0, 5));
    const Symmetric k = matrix_of(random.basis(), {size, random.uniform(0, size), random.uniform(-0.2, 1) * size});
    std::array<double, 3> values = axes_of(k).values;
    std::sort(values.begin(), values.end(), std::greater<>());
    const std::array<double, 3> expected = values_by_cosine(k);
    // The cosine loses half of the digits where values meet.
    for (std::size_t a = 0; a < 3; ++a) REQUIRE(std::abs(values[a] - expected[a]) <= 4e-8 * size);
    const double cap = random.uniform(0.05, 0.95) * size;
    ContactRecord record;
    record.stiffness_N_per_m = k;
    const std::array<double, 3> capped = values_by_cosine(softened(record, cap).record.stiffness_N_per_m);
    for (std::size_t a = 0; a < 3; ++a) REQUIRE(std::abs(capped[a] - std::min(expected[a], cap)) <= 4e-8 * size);
  }
}

TEST_CASE("a contact that is turned is softened to the turned result, with its force and coupling, 20,000 rotations") {
  Random random(6);
  for (int i = 0; i < evenstep::testing::cases(20'000); ++i) {
    const auto to = random.basis();
    const double size = std::pow(10, random.uniform(0, 5)), cap = random.uniform(0.05, 0.95) * size;
    ContactRecord record{random.vector(10),
                         random.vector(0.1),
                         matrix_of(random.basis(), {size, random.uniform(0, size), random.uniform(0, size)}),
                         {},
                         0,
                         false,
                         {}};
    const glm::dvec3 row = random.vector(size), column = random.vector(1);
    record.coupling_N_per_m = glm::outerProduct(row, column);
    ContactRecord other = record;
    other.force_N = turned(record.force_N, to);
    other.stiffness_N_per_m = turned(record.stiffness_N_per_m, to);
    other.coupling_N_per_m = glm::outerProduct(turned(row, to), turned(column, to));
    const ContactRecord soft = softened(record, cap).record, soft_other = softened(other, cap).record;
    // An axis is less exact the closer its value is to the next one. That does not matter to S, as equal values have equal
    // shares. Room for a few roundings of the largest value, and of 10 N.
    REQUIRE(most_apart(soft_other.stiffness_N_per_m, turned(soft.stiffness_N_per_m, to)) <= 200 * kEpsilon * size);
    REQUIRE(length(soft_other.force_N - turned(soft.force_N, to)) <= 1e-10);
    // C is softened like a force: S C.
    const glm::dvec3 along = random.vector(1), push = soft.coupling_N_per_m * along;
    REQUIRE(length(soft_other.coupling_N_per_m * turned(along, to) - turned(push, to)) <= 1e-11 * size);
    ContactRecord force = record;
    force.force_N = record.coupling_N_per_m * along;
    REQUIRE(length(softened(force, cap).record.force_N - push) <= 1e-11 * size);
  }
}

TEST_CASE("over a closed path a held local force makes half the sum of d K d and no more, with and without a cap") {
  // Between ticks the force is held, so on each way d it gives d K d / 2 too much. Nothing else can be gained from a
  // potential, however the path runs. A matrix that is not symmetric would act as a motor.
  Random random(7);
  for (int i = 0; i < evenstep::testing::cases(2'000); ++i) {
    const double size = std::pow(10, random.uniform(0, 4));
    ContactRecord record{random.vector(1),
                         random.vector(0.01),
                         matrix_of(random.basis(), {size, random.uniform(0, size), random.uniform(0, size)}),
                         {},
                         0,
                         false,
                         {}};
    const double cap = i % 2 == 0 ? kInfinity : random.uniform(0.05, 0.95) * size;
    const AffineContact contact = affine_contact(softened(record, cap).record, true);
    const LocalRenderer local(1);
    const glm::dvec3 home = random.vector(0.01);
    glm::dvec3 at = home;
    double made_J = 0, half_J = 0, way_m2 = 0;
    for (int n = 0; n < 40; ++n) {
      const glm::dvec3 next = n == 39 ? home : random.vector(0.01), way = next - at;
      made_J += dot(local.force_N(contact, Duration{0}, at), way);
      half_J += quadratic(contact.stiffness_N_per_m, way) / 2;
      way_m2 += dot(way, way);
      at = next;
    }
    REQUIRE(made_J == Approx(half_J).epsilon(1e-9));
    REQUIRE(made_J <= std::min(size, cap) / 2 * way_m2 * (1 + 1e-9));
  }
}

TEST_CASE("a surface under its cap makes no more over a closed path that leaves it and comes back, 2,000 paths") {
  Random random(8);
  int outside = 0;
  for (int i = 0; i < evenstep::testing::cases(2'000); ++i) {
    const std::array<glm::dvec3, 3> axes = random.basis();
    const double stiffness = random.uniform(100, 5000), cap = random.uniform(50, 6000),
                 gap_m = random.uniform(-0.005, 0.005);
    const ContactRecord wall{axes[0] * (stiffness * std::max(0.0, -gap_m)),
                             axes[0] * gap_m,
                             matrix_of(axes, {stiffness, 0, 0}),
                             axes[0],
                             gap_m,
                             true,
                             {}};
    const AffineContact contact = affine_contact(softened(wall, cap).record, true);
    const LocalRenderer local(1);
    const glm::dvec3 home = random.vector(0.01);
    glm::dvec3 at = home;
    double made_J = 0, bound_J = 0;
    for (int n = 0; n < 40; ++n) {
      const glm::dvec3 next = n == 39 ? home : random.vector(0.01), way = next - at;
      const glm::dvec3 force_N = local.force_N(contact, Duration{0}, at);
      REQUIRE(dot(axes[0], force_N) >= 0);
      outside += force_N == glm::dvec3(0);
      made_J += dot(force_N, way);
      bound_J += std::min(stiffness, cap) * dot(way, axes[0]) * dot(way, axes[0]) / 2;
      at = next;
    }
    REQUIRE(made_J <= bound_J * (1 + 1e-9) + 1e-15);
  }
  CHECK(outside > evenstep::testing::cases(20'000));
}

TEST_CASE("two coupled hands make half the sum of d K d of both together, 2,000 closed paths") {
  Random random(9);
  for (int i = 0; i < evenstep::testing::cases(2'000); ++i) {
    // [K C; C' K'] = sum of (a, b)(a, b)', which is what springs between any two points of the tissue give.
    std::array<glm::dmat3, 2> k{glm::dmat3(0), glm::dmat3(0)};
    glm::dmat3 c(0);
    for (int spring = 0; spring < 5; ++spring) {
      const glm::dvec3 a = random.vector(10), b = random.vector(10);
      k[0] += glm::outerProduct(a, a);
      k[1] += glm::outerProduct(b, b);
      c += glm::outerProduct(a, b);
    }
    std::array<AffineContact, 2> contact;
    const std::array<glm::dvec3, 2> rest{random.vector(0.01), random.vector(0.01)};
    for (std::size_t hand = 0; hand < 2; ++hand) {
      const glm::dmat3& s = k[hand];
      contact[hand].stiffness_N_per_m = {s[0][0], s[1][1], s[2][2], s[1][0], s[2][0], s[2][1]};
      contact[hand].coupling_N_per_m = hand == 0 ? c : glm::transpose(c);
      contact[hand].tool_m = rest[hand];
      contact[hand].other_m = rest[1 - hand];
      contact[hand].force_N = random.vector(1);
    }
    const LocalRenderer local(1);
    const std::array<glm::dvec3, 2> home{random.vector(0.01), random.vector(0.01)};
    std::array<glm::dvec3, 2> at = home;
    double made_J = 0, half_J = 0;
    for (int n = 0; n < 40; ++n) {
      std::array<glm::dvec3, 2> next{random.vector(0.01), random.vector(0.01)};
      if (n == 39) next = home;
      const std::array<glm::dvec3, 2> way{next[0] - at[0], next[1] - at[1]};
      for (std::size_t hand = 0; hand < 2; ++hand)
        made_J += dot(local.force_N(contact[hand], Duration{0}, at[hand], &at[1 - hand]), way[hand]);
      half_J += (dot(way[0], k[0] * way[0]) + dot(way[1], k[1] * way[1])) / 2 + dot(way[0], c * way[1]);
      at = next;
    }
    REQUIRE(made_J == Approx(half_J).epsilon(1e-9));
    // Without the other hand the coupling is not played.
    REQUIRE(length(local.force_N(contact[0], Duration{0}, rest[0]) - contact[0].force_N) <= 1e-12);
  }
}

namespace {

/// The two records of a pair whose joint stiffness is [K C; C' K'].
std::array<ContactRecord, 2> pair_of(const Joint& m) {
  const auto block = [&](std::size_t r, std::size_t c) {
    glm::dmat3 k(0);
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 3; ++column)
        k[static_cast<int>(column)][static_cast<int>(row)] = m[3 * r + row][3 * c + column];
    return k;
  };
  std::array<ContactRecord, 2> pair;
  for (std::size_t hand = 0; hand < 2; ++hand) {
    const glm::dmat3 own = block(hand, hand), other = block(1 - hand, 1 - hand);
    const auto symmetric = [](const glm::dmat3& k) {
      return Symmetric{k[0][0], k[1][1], k[2][2], k[1][0], k[2][0], k[2][1]};
    };
    pair[hand].stiffness_N_per_m = symmetric(own);
    pair[hand].other_stiffness_N_per_m = symmetric(other);
    pair[hand].coupling_N_per_m = block(hand, 1 - hand);
  }
  return pair;
}

/// The stiffness [K C; C' K'] that both hands play together, with each hand's rows from its own record.
Joint played_by(const std::array<ContactRecord, 2>& pair) {
  Joint m{};
  for (std::size_t hand = 0; hand < 2; ++hand) {
    const Symmetric& k = pair[hand].stiffness_N_per_m;
    const double own[3][3] = {{k.xx, k.xy, k.xz}, {k.xy, k.yy, k.yz}, {k.xz, k.yz, k.zz}};
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        m[3 * hand + r][3 * hand + c] = own[r][c];
        m[3 * hand + r][3 * (1 - hand) + c] = pair[hand].coupling_N_per_m[static_cast<int>(c)][static_cast<int>(r)];
      }
    }
  }
  return m;
}

std::array<double, 6> times(const Joint& m, const std::array<double, 6>& v) {
  std::array<double, 6> out{};
  for (std::size_t r = 0; r < 6; ++r)
    for (std::size_t c = 0; c < 6; ++c) out[r] += m[r][c] * v[c];
  return out;
}

/// The largest eigenvalue of a positive semidefinite matrix, computed in an independent way: by iteration, from below.
double largest_by_iteration(const Joint& m, Random& random) {
  std::array<double, 6> v{};
  for (double& x : v) x = random.uniform(0.5, 1);
  double value = 0;
  for (int n = 0; n < 400; ++n) {
    const std::array<double, 6> next = times(m, v);
    double square = 0;
    for (const double x : next) square += x * x;
    value = std::sqrt(square);
    if (value == 0) return 0;
    for (std::size_t i = 0; i < 6; ++i) v[i] = next[i] / value;
  }
  return value;
}

Joint springs_between(Random& random, int count) {
  Joint m{};
  for (int spring = 0; spring < count; ++spring) {
    std::array<double, 6> v{};
    for (double& x : v) x = random.uniform(-20, 20);
    for (std::size_t r = 0; r < 6; ++r)
      for (std::size_t c = 0; c < 6; ++c) m[r][c] += v[r] * v[c];
  }
  return m;
}

}  // namespace

TEST_CASE("two hands at springs of their own and one between them: stiffest and cap are the closed form's, 20,000 cases") {
  Random random(21);
  int above_twice = 0;
  for (int i = 0; i < evenstep::testing::cases(20'000); ++i) {
    // Along one direction n: [k + c, -c; -c, k' + c] has the values mean +- sqrt((k - k')^2 / 4 + c^2).
    const glm::dvec3 n = random.basis()[0];
    const double k = random.uniform(0, 100), other = random.uniform(0, 100), c = random.uniform(0, 300);
    const std::array<double, 6> left{n.x, n.y, n.z, 0, 0, 0}, right{0, 0, 0, n.x, n.y, n.z};
    Joint m{};
    for (std::size_t r = 0; r < 6; ++r)
      for (std::size_t s = 0; s < 6; ++s)
        m[r][s] =
            (k + c) * left[r] * left[s] + (other + c) * right[r] * right[s] - c * (left[r] * right[s] + right[r] * left[s]);
    const double mean = (k + other) / 2 + c, half = std::sqrt((k - other) * (k - other) / 4 + c * c);
    const double stiffest = mean + half, least = mean - half;
    const double cap = random.uniform(0.05, 1.2) * stiffest;
    const std::array<ContactRecord, 2> pair = pair_of(m);
    const Softened first = softened_together(pair[0], cap), second = softened_together(pair[1], cap);
    REQUIRE(std::abs(first.stiffest_N_per_m - stiffest) <= 1e-12 * stiffest);
    const Joint played = played_by({first.record, second.record});
    // The trace in the plane of n is the sum of both values.
    const double a = times(played, left)[0] * n.x + times(played, left)[1] * n.y + times(played, left)[2] * n.z;
    const double d = times(played, right)[3] * n.x + times(played, right)[4] * n.y + times(played, right)[5] * n.z;
    REQUIRE(std::abs(a + d - std::min(stiffest, cap) - std::min(least, cap)) <= 1e-11 * stiffest);
    for (std::size_t r = 0; r < 6; ++r)
      for (std::size_t s = 0; s < 6; ++s) REQUIRE(std::abs(played[r][s] - played[s][r]) <= 1e-11 * stiffest);
    // Control: if each hand is capped alone, the two against each other are still stiffer than the cap.
    const Joint alone = played_by({softened(pair[0], cap).record, softened(pair[1], cap).record});
    above_twice += largest_by_iteration(alone, random) > 1.5 * cap ? 1 : 0;
  }
  CHECK(above_twice > evenstep::testing::cases(2'000));
}

TEST_CASE("together no direction is stiffer than the cap, force and stiffness soften alike, 2,000 pairs of hands") {
  Random random(22);
  for (int i = 0; i < evenstep::testing::cases(2'000); ++i) {
    const Joint m = springs_between(random, 1 + i % 8);
    const double stiffest = largest_by_iteration(m, random), cap = random.uniform(0.1, 0.9) * stiffest;
    std::array<ContactRecord, 2> pair = pair_of(m);
    // The forces of springs that are stretched by x.
    std::array<double, 6> x{};
    for (double& at : x) at = random.uniform(-0.01, 0.01);
    const std::array<double, 6> force = times(m, x);
    pair[0].force_N = pair[1].other_force_N = glm::dvec3(-force[0], -force[1], -force[2]);
    pair[1].force_N = pair[0].other_force_N = glm::dvec3(-force[3], -force[4], -force[5]);
    const std::array<ContactRecord, 2> soft{softened_together(pair[0], cap).record, softened_together(pair[1], cap).record};
    // The iteration comes from below and is slow where two values are close.
    REQUIRE(softened_together(pair[0], cap).stiffest_N_per_m >= stiffest * (1 - 1e-12));
    REQUIRE(softened_together(pair[0], cap).stiffest_N_per_m <= stiffest * 1.01);
    const Joint played = played_by(soft);
    REQUIRE(largest_by_iteration(played, random) <= cap * (1 + 1e-9));
    // The softer springs, stretched as far, give the softer forces.
    const std::array<double, 6> softer = times(played, x);
    for (std::size_t hand = 0; hand < 2; ++hand) {
      const glm::dvec3 expected(-softer[3 * hand], -softer[3 * hand + 1], -softer[3 * hand + 2]);
      REQUIRE(length(soft[hand].force_N - expected) <= 1e-11 * stiffest);
    }
  }
}

TEST_CASE("a pair that is soft enough passes bit for bit, and so does one that is not a number") {
  Random random(23);
  const std::array<ContactRecord, 2> pair = pair_of(springs_between(random, 6));
  const Softened soft = softened_together(pair[0], 1e9);
  CHECK(same_bits(soft.record.stiffness_N_per_m, pair[0].stiffness_N_per_m));
  CHECK(soft.record.coupling_N_per_m == pair[0].coupling_N_per_m);
  ContactRecord broken = pair[0];
  broken.other_stiffness_N_per_m.yy = std::numeric_limits<double>::quiet_NaN();
  const Softened same = softened_together(broken, 1);
  CHECK(same_bits(same.record.stiffness_N_per_m, pair[0].stiffness_N_per_m));
  CHECK_FALSE(std::isfinite(same.stiffest_N_per_m));
}
