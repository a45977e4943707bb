#include "src/fits/sine_fit.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "evenstep/time/reproducible_math.h"
#include "src/vec3.h"

namespace evenstep::internal {
namespace {

double mean(const Rows<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Subtracts the mean, which removes the constant from the fit.
void centre(Rows<double>& values) {
  const double middle = mean(values);
  for (double& value : values) value -= middle;
}

double dot(const Rows<double>& a, const Rows<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// The component along the direction, relative to the first value, so that a small motion far from the origin loses no
/// digits.
Rows<double> component(std::span<const Vec3> x, const Vec3& direction, const RowAllocator<double>& beside) {
  const double length = norm(direction);
  Rows<double> values(beside);
  for (const Vec3& value : x) {
    const Vec3 from_first = minus(value, x.front());
    values.push_back((from_first[0] * direction[0] + from_first[1] * direction[1] + from_first[2] * direction[2]) / length);
  }
  return values;
}

}  // namespace

SineFit fit_sine(std::span<const double> t_s, std::span<const Vec3> x, const Vec3& direction, double frequency_Hz,
                 double begin_s, const RowAllocator<double>& beside) {
  const SineFit none{kNone, kNone, kNone};
  const double count = static_cast<double>(t_s.size());
  if (t_s.size() < 3) return none;
  // A sample covers its period. The billionth allows for rounded times that miss a whole period by that much.
  const double covered_s = (t_s.back() - t_s.front()) * count / (count - 1);
  if (covered_s * frequency_Hz < 1 - 1e-9) return none;
  Rows<double> cosine(beside), sine(beside);
  for (const double t : t_s) {
    const double turns = (t - begin_s) * frequency_Hz;
    const double angle = 2 * std::numbers::pi * (turns - std::floor(turns));
    cosine.push_back(reproducible::cos(angle));
    sine.push_back(reproducible::sin(angle));
  }
  Rows<double> value = component(x, direction, beside);
  for (Rows<double>* column : {&cosine, &sine, &value}) centre(*column);
  const double cc = dot(cosine, cosine), ss = dot(sine, sine), cs = dot(cosine, sine);
  const double determinant = cc * ss - cs * cs;
  // The determinant is count^2 / 4 if the samples are spread evenly over the turn, and near 0 if they all fall on two points
  // of it or fewer.
  if (!(determinant > 1e-6 * count * count / 4)) return none;
  const double cx = dot(cosine, value), sx = dot(sine, value);
  const double b = (cx * ss - sx * cs) / determinant, c = (sx * cc - cx * cs) / determinant;
  const double amplitude = std::sqrt(b * b + c * c);
  if (!(amplitude > 0)) return {amplitude, kNone, kNone};
  double squares = 0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const double rest = value[i] - b * cosine[i] - c * sine[i];
    squares += rest * rest;
  }
  // u delayed by d is (1 - cos(w d) cos - sin(w d) sin) / 2: both coefficients negative for a small delay.
  const double delay_s = std::atan2(-c, -b) / (2 * std::numbers::pi * frequency_Hz);
  return {2 * amplitude, delay_s, std::sqrt(squares / count) / (amplitude / std::numbers::sqrt2)};
}

}  // namespace evenstep::internal
