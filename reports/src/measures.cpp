#include "evenstep/reports/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "evenstep/time/reproducible_math.h"
#include "src/line_measures.h"
#include "src/vec3.h"

namespace evenstep {
using internal::kNone;

namespace {

constexpr std::size_t kLeastSamples = 3;  // any two points lie on a line, so fewer than three judge nothing

/// cos and sin of 2 pi i / count, computed by reproducible functions, because the bits of a summary must not depend on the C
/// library.
struct Circle {
  explicit Circle(std::size_t count) : cosine(count), sine(count) {
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
      cosine[i] = reproducible::cos(angle);
      sine[i] = reproducible::sin(angle);
    }
  }
  std::vector<double> cosine, sine;
};

/// |X_k|^2 of one axis.
double bin_power(std::span<const Vec3> x, std::size_t axis, std::size_t k, const Circle& circle) {
  double re = 0, im = 0;
  std::size_t phase = 0;  // k * i mod count, exact
  for (const Vec3& value : x) {
    re += value[axis] * circle.cosine[phase];
    im += value[axis] * circle.sine[phase];
    phase += k;
    if (phase >= x.size()) phase -= x.size();
  }
  return re * re + im * im;
}

bool flat(std::span<const Vec3> x, std::size_t axis) {
  for (const Vec3& value : x) {
    if (value[axis] != 0) return false;
  }
  return true;
}

/// The part of the sum of squares of x that lies in the bins [first, last] (by Parseval; a bin below the Nyquist frequency
/// also counts for its mirror image).
double band_energy(std::span<const Vec3> x, std::size_t first, std::size_t last) {
  const Circle circle(x.size());
  double energy = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (flat(x, axis)) continue;
    for (std::size_t k = first; k <= last; ++k) {
      const double mirror = 2 * k == x.size() ? 1 : 2;
      energy += mirror * bin_power(x, axis, k, circle) / static_cast<double>(x.size());
    }
  }
  return energy;
}

}  // namespace

double velocity_jump(std::span<const Vec3> x) {
  const internal::Window whole{0, x.size()};
  return internal::velocity_jump(x, std::span(&whole, 1));
}

double jump_max(std::span<const Vec3> x) {
  if (x.size() < 2) return kNone;
  internal::Peak peak;
  for (std::size_t n = 1; n < x.size(); ++n) peak.add(internal::norm(internal::minus(x[n], x[n - 1])));
  return peak.value;
}

double rise_max(std::span<const Vec3> x) {
  if (x.size() < 2) return kNone;
  internal::Peak peak;
  for (std::size_t n = 1; n < x.size(); ++n) peak.add(internal::norm(x[n]) - internal::norm(x[n - 1]));
  return peak.value;
}

Deviation deviation(std::span<const double> t, std::span<const Vec3> x, double window_s) {
  return internal::deviation(t, x, internal::windows(t, window_s));
}

double band_rms(std::span<const double> t, std::span<const Vec3> x, double window_s, double low_Hz, double high_Hz) {
  return internal::band_rms(t, x, internal::windows(t, window_s), low_Hz, high_Hz);
}

namespace internal {

double velocity_jump(std::span<const Vec3> x, std::span<const Window> pieces) {
  Peak peak;
  bool any = false;
  for (const Window& piece : pieces) {
    for (std::size_t n = piece.begin + 1; n + 1 < piece.end; ++n) {
      peak.add(norm(minus(minus(x[n + 1], x[n]), minus(x[n], x[n - 1]))));
      any = true;
    }
  }
  return any ? peak.value : kNone;
}

Deviation deviation(std::span<const double> t, std::span<const Vec3> x, std::span<const Window> windows) {
  Peak peak;
  double squares = 0;
  std::size_t judged = 0;
  for (const Window& window : windows) {
    if (window.size() < kLeastSamples) continue;
    for (const Vec3& r : line_residual(t.subspan(window.begin, window.size()), x.subspan(window.begin, window.size()))) {
      peak.add(norm(r));
      squares += r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    }
    judged += window.size();
  }
  if (judged == 0) return {kNone, kNone};
  return {peak.value, std::sqrt(squares / static_cast<double>(judged))};
}

double band_rms(std::span<const double> t, std::span<const Vec3> x, std::span<const Window> windows, double low_Hz,
                double high_Hz) {
  double energy = 0;
  std::size_t judged = 0;
  for (const Window& window : windows) {
    const std::size_t count = window.size();
    if (count < kLeastSamples) continue;
    const auto times = t.subspan(window.begin, count);
    const double length_s = (times.back() - times.front()) * static_cast<double>(count) / static_cast<double>(count - 1);
    // Bin k is at k / length_s Hz; the billionth keeps a bin that lies exactly on an edge inside.
    const auto first = static_cast<std::size_t>(std::max(1.0, std::ceil(low_Hz * length_s * (1 - 1e-9))));
    const auto last = std::min(count / 2, static_cast<std::size_t>(std::floor(high_Hz * length_s * (1 + 1e-9))));
    if (first > last) continue;
    energy += band_energy(line_residual(times, x.subspan(window.begin, count)), first, last);
    judged += count;
  }
  return judged == 0 ? kNone : std::sqrt(energy / static_cast<double>(judged));
}

}  // namespace internal
}  // namespace evenstep
