#include "evenstep/reports/measures.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "catch.h"
#include "src/fits/line_fit.h"
#include "src/vec3.h"

using namespace evenstep;

namespace {

constexpr std::size_t kWindow = 250;  // samples of 1 kHz in 250 ms

std::vector<double> times(std::size_t count, double rate_Hz, double offset_s = 0) {
  std::vector<double> t;
  for (std::size_t i = 0; i < count; ++i) t.push_back(offset_s + static_cast<double>(i) / rate_Hz);
  return t;
}

/// 0.1 m/s along a direction that is not an axis, starting far away, as in a long run.
Vec3 on_line(double t) { return {3 + 0.06 * t, -1 + 0.08 * t, 0.5 - 0.001 * t}; }

std::vector<Vec3> line(const std::vector<double>& t) {
  std::vector<Vec3> x;
  for (const double at : t) x.push_back(on_line(at));
  return x;
}

/// A cosine around the middle of its window with a whole number k of periods. It is orthogonal to every line, so it is its
/// own residual.
double even_wave(std::size_t i, std::size_t k, std::size_t count) {
  return std::cos(2 * std::numbers::pi * static_cast<double>(k) *
                  (static_cast<double>(i % count) - (static_cast<double>(count) - 1) / 2) / static_cast<double>(count));
}

std::vector<Vec3> wave(std::size_t count, std::size_t k, std::size_t period, double amplitude) {
  std::vector<Vec3> x;
  for (std::size_t i = 0; i < count; ++i) x.push_back({0, amplitude * even_wave(i, k, period), 0});
  return x;
}

/// Uniform in [-1, 1): a plain 64-bit LCG, for data only.
struct Noise {
  std::uint64_t state;
  double next() {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(static_cast<std::int64_t>(state) >> 11) * 0x1p-52;
  }
};

}  // namespace

TEST_CASE("velocity_jump of a spike of d is 2 d, wherever it stands") {
  const std::vector<double> t = times(60, 1000);
  for (std::size_t at = 1; at + 1 < t.size(); ++at) {
    std::vector<Vec3> x = line(t);
    x[at][2] += 1e-3;
    CHECK(velocity_jump(x) == Approx(2e-3).margin(1e-14));  // rounding of values near 3: 4e-16 each
  }
}

TEST_CASE("velocity_jump of a kink is the change of the distance per sample") {
  std::vector<Vec3> x;
  for (int i = 0; i < 40; ++i) x.push_back({i < 20 ? 0.001 * i : 0.02 + 0.004 * (i - 20), 0, 0});
  CHECK(velocity_jump(x) == Approx(0.003).epsilon(1e-12));
}

TEST_CASE("jump_max is the largest change, as a vector") {
  for (std::size_t at = 1; at < 30; ++at) {
    std::vector<Vec3> x(30, Vec3{1, 2, 3});
    for (std::size_t i = at; i < x.size(); ++i) x[i] = {1 + 0.3, 2, 3 - 0.4};
    CHECK(jump_max(x) == Approx(0.5).epsilon(1e-12));
  }
}

TEST_CASE("rise_max is the largest growth of the length, whatever falls or turns meanwhile") {
  CHECK(rise_max(std::vector<Vec3>{{3, 4, 0}, {0, 0, 0}, {0, 0, 1}, {0, 1.5, 0}, {0.6, 0, 0.8}}) == Approx(1));
  CHECK(rise_max(std::vector<Vec3>{{2, 0, 0}, {1, 0, 0}, {0, -1, 0}}) == 0);
  CHECK(std::isnan(rise_max(std::vector<Vec3>(1))));
}

TEST_CASE("an exact line has no deviation, also 1000 s and 100 m from the origin") {
  for (const double offset_s : {0.0, 1.0, 60.0, 1000.0}) {
    const std::vector<double> t = times(2000, 1000, offset_s);
    // The inputs themselves are rounded to 1.4e-14 m at 100 m (and 1.1e-13 s at 0.1 m/s). 1e-13 m is 5e-10 of a step.
    const Deviation d = deviation(t, line(t), 0.25);
    CHECK(d.max < 1e-13);
    CHECK(d.rms <= d.max);
  }
}

TEST_CASE("a known residual on a line is found to 1e-13 m, also at 1000 s") {
  for (const double offset_s : {0.0, 1000.0}) {
    for (std::size_t k = 1; k <= 124; ++k) {
      const std::vector<double> t = times(4 * kWindow, 1000, offset_s);
      std::vector<Vec3> x = line(t);
      double largest = 0;
      for (std::size_t i = 0; i < x.size(); ++i) {
        x[i][0] += 1e-3 * even_wave(i, k, kWindow);
        largest = std::max(largest, std::abs(1e-3 * even_wave(i, k, kWindow)));
      }
      const Deviation d = deviation(t, x, 0.25);
      CHECK(d.max == Approx(largest).margin(1e-13));
      CHECK(d.rms == Approx(1e-3 / std::sqrt(2.0)).margin(1e-13));
    }
  }
}

TEST_CASE("the residual equals that of long double normal equations (100 random series)") {
  Noise noise{7};
  for (int run = 0; run < 100; ++run) {
    std::vector<double> t;
    std::vector<Vec3> x;
    for (int i = 0; i < 40; ++i) {
      t.push_back((t.empty() ? 10 * noise.next() : t.back()) + 0.001 * (1.5 + noise.next()));
      x.push_back({noise.next(), 5 + noise.next(), 0});
    }
    const std::vector<Vec3> r = internal::line_residual(t, x);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      long double n = 0, st = 0, sx = 0, stt = 0, stx = 0;
      for (std::size_t i = 0; i < t.size(); ++i) {
        n += 1, st += t[i], sx += x[i][axis], stt += static_cast<long double>(t[i]) * t[i],
            stx += static_cast<long double>(t[i]) * x[i][axis];
      }
      const long double slope = (n * stx - st * sx) / (n * stt - st * st), start = (sx - slope * st) / n;
      for (std::size_t i = 0; i < t.size(); ++i) {
        // In long double (1e-19) the reference loses a factor of (10 s / 40 ms)^2.
        CHECK(r[i][axis] == Approx(static_cast<double>(x[i][axis] - start - slope * t[i])).margin(1e-12));
      }
    }
  }
}

TEST_CASE("windows are 250 ms long and a rest under 125 ms joins the last: every length to 1500 samples") {
  for (const double offset_s : {0.0, 0.1, 999.9, 1000.1}) {
    for (std::size_t count = 1; count <= 1500; ++count) {
      const std::vector<double> t = times(count, 1000, offset_s);
      const std::vector<internal::Window> windows = internal::windows(t, 0.25);
      const std::size_t full = count / kWindow, rest = count % kWindow;
      const bool own = rest >= kWindow / 2 || (full == 0 && rest > 0);
      REQUIRE(windows.size() == full + (own ? 1 : 0));
      std::size_t at = 0;
      for (std::size_t w = 0; w < windows.size(); ++w) {
        REQUIRE(windows[w].begin == at);
        REQUIRE(windows[w].end == (w + 1 == windows.size() ? count : at + kWindow));
        at = windows[w].end;
      }
    }
  }
}

TEST_CASE("a window of 450 Hz steps is closed where 250 ms are over") {
  const std::vector<internal::Window> windows = internal::windows(times(450, 450), 0.25);  // 112.5 steps each
  REQUIRE(windows.size() == 4);
  CHECK(windows[1].begin == 113);
  CHECK(windows[2].begin == 225);
  CHECK(windows[3].begin == 338);
}

TEST_CASE("a hole in the samples leaves no empty window") {
  std::vector<double> t = times(250, 1000);
  for (const double later : times(250, 1000, 3.0)) t.push_back(later);
  CHECK(internal::windows(t, 0.25).size() == 2);
}

TEST_CASE("fewer than three samples judge nothing: NaN, never 0") {
  const std::vector<double> t = times(2, 1000);
  CHECK(std::isnan(deviation(t, line(t), 0.25).max));
  CHECK(std::isnan(deviation(t, line(t), 0.25).rms));
  CHECK(std::isnan(velocity_jump(line(t))));
  CHECK(std::isnan(jump_max(std::vector<Vec3>(1))));
  CHECK(std::isnan(band_rms(t, line(t), 0.25, 20, 500)));
  const std::vector<double> slow = times(20, 8);  // two samples per window
  CHECK(std::isnan(deviation(slow, line(slow), 0.25).max));
}

TEST_CASE("a NaN anywhere is a NaN everywhere") {
  const std::vector<double> t = times(300, 1000);
  for (std::size_t at = 0; at < t.size(); ++at) {
    std::vector<Vec3> x = line(t);
    x[at][1] = std::numeric_limits<double>::quiet_NaN();
    CHECK(std::isnan(velocity_jump(x)));
    CHECK(std::isnan(jump_max(x)));
    CHECK(std::isnan(deviation(t, x, 0.25).max));
    CHECK(std::isnan(deviation(t, x, 0.25).rms));
    CHECK(std::isnan(band_rms(t, x, 0.25, 20, 500)));
  }
}

TEST_CASE("band_rms of a sine is A / sqrt 2 inside 20 to 500 Hz, edges included, and 0 outside") {
  constexpr std::size_t kCount = 1000;  // 4 kHz, 250 ms: bins of 4 Hz
  const std::vector<double> t = times(kCount, 4000, 12.0);
  for (std::size_t k = 1; k < 300; ++k) {
    const double expected = k >= 5 && k <= 125 ? 2.0 / std::sqrt(2.0) : 0;
    CHECK(band_rms(t, wave(kCount, k, kCount, 2.0), 0.25, 20, 500) == Approx(expected).margin(1e-12));
  }
}

TEST_CASE("band_rms of a chirp is that of its sines in the band") {
  constexpr std::size_t kCount = 1000;
  const std::vector<double> t = times(kCount, 4000);
  std::vector<Vec3> x(kCount, Vec3{});
  double inside = 0;
  for (std::size_t k = 1; k < 250; ++k) {
    const double amplitude = 0.1 + 0.01 * static_cast<double>(k % 7);
    for (std::size_t i = 0; i < kCount; ++i) x[i][k % 3] += amplitude * even_wave(i, k, kCount);
    if (k >= 5 && k <= 125) inside += amplitude * amplitude / 2;
  }
  CHECK(band_rms(t, x, 0.25, 20, 500) == Approx(std::sqrt(inside)).epsilon(1e-12));
}

TEST_CASE("a 1 kHz device's 500 Hz is counted once") {
  const std::vector<double> t = times(kWindow, 1000);
  std::vector<Vec3> x;
  for (std::size_t i = 0; i < kWindow; ++i) x.push_back({i % 2 == 0 ? 0.5 : -0.5, 0, 0});
  // Detrending removes 3 / count^2 of the power of an alternating series, which is 5e-5.
  CHECK(band_rms(t, x, 0.25, 20, 500) == Approx(0.5).epsilon(1e-4));
}

TEST_CASE("a ramp of any slope has no band_rms, windows are pooled by their samples") {
  const std::vector<double> t = times(2 * kWindow, 1000, 1000.0);
  CHECK(band_rms(t, line(t), 0.25, 20, 500) < 1e-13);
  std::vector<Vec3> x = line(t);
  for (std::size_t i = 0; i < kWindow; ++i) x[i][0] += 0.3 * even_wave(i, 10, kWindow);  // first window only
  CHECK(band_rms(t, x, 0.25, 20, 500) == Approx(0.3 / std::sqrt(2.0) / std::sqrt(2.0)).epsilon(1e-10));
}
