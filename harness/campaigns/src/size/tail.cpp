#include "tail.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "evenstep/harness/trust.h"

namespace evenstep::internal {
namespace {

constexpr double kLeastShape = -0.5;  // below, the likelihood has no regular maximum (Smith, Biometrika 72, 1985)
constexpr double kNextLevel = 0.7;    // share of the exceedances that the next candidate has
constexpr int kPlaces = 160;          // of s/w on either side of 0
constexpr int kShares = 24;           // in which the slack of the likelihood is divided between z and the rest
constexpr int kHalvings = 40;

/// For q = s/w the likelihood needs the exceedances only in the mean of log(1 + q y): per exceedance it is
///   -log(s/q) - (1 + 1/s) mean,  largest at s = mean.
struct Candidate {
  double q = 0, mean = 0;
  double likelihood(double shape) const { return -std::log(shape / q) - (1 + 1 / shape) * mean; }
};

std::vector<Candidate> places_of(std::span<const double> exceedances) {
  const auto m = static_cast<double>(exceedances.size());
  const double average = std::accumulate(exceedances.begin(), exceedances.end(), 0.0) / m;
  const double largest = *std::max_element(exceedances.begin(), exceedances.end());
  std::vector<Candidate> places;
  const auto add = [&](double q) {
    double sum = 0;
    for (const double y : exceedances) sum += std::log1p(q * y);
    if (const double mean = sum / m; mean >= kLeastShape && mean != 0) places.push_back({q, mean});
  };
  for (int i = 0; i < kPlaces; ++i) {
    const double part = (i + 0.5) / kPlaces;
    add(-(1 - std::pow(10, -4 * part)) / largest);  // up to where the largest value is the end of the tail
    add(std::pow(10, 7 * part - 4) / average);
  }
  return places;
}

/// Points of W^2 that a fitted law exceeds in one case of ten, by shape (simulated: tail_test.cpp).
double fit_limit(double shape) { return 0.119 - 0.04 * shape + 0.016 * shape * shape; }

/// Cramer and von Mises, of exceedances in rising order.
double misfit(std::span<const double> exceedances, double shape, double scale) {
  const auto m = static_cast<double>(exceedances.size());
  double sum = 1 / (12 * m);
  for (std::size_t i = 0; i < exceedances.size(); ++i) {
    const double below = -std::expm1(-std::log1p(shape * exceedances[i] / scale) / shape);
    const double place = (static_cast<double>(i) + 0.5) / m;
    sum += (below - place) * (below - place);
  }
  return sum;
}

/// The most that f, which falls after `peak`, keeps at or above `least` for, going away from the peak by factors.
template <class F>
double farthest(double peak, double least, double limit, F f) {
  if (f(limit) >= least) return limit;
  double in = peak, out = limit;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (in + out) / 2;
    (f(middle) >= least ? in : out) = middle;
  }
  return in;
}

double quantile(const Tail& tail, double above, double share) {
  return tail.level + std::expm1(tail.shape * std::log(above / share)) * tail.scale / tail.shape;
}

/// How much each value moves the most likely quantile (influence function): its gradient by share above, scale and shape,
/// times the inverse of the expected information, times the score of the value.
std::vector<double> influences(std::span<const double> values, const Tail& tail, double above, double share) {
  const double s = tail.shape, w = tail.scale, ratio = std::log(above / share), grown = std::exp(s * ratio);
  const double by_above = w * grown / above, by_scale = (grown - 1) / s;
  const double by_shape = w * (ratio * grown * s - (grown - 1)) / (s * s);
  std::vector<double> out(values.size(), -above * by_above);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double y = (values[i] - tail.level) / w;
    if (y <= 0) continue;
    const double inner = 1 + s * y;
    const double scale_score = ((1 + s) * y / inner - 1) / w;
    const double shape_score = std::log(inner) / (s * s) - (1 + 1 / s) * y / inner;
    const double to_scale = (1 + s) * (2 * w * w * scale_score - w * shape_score);
    const double to_shape = (1 + s) * (-w * scale_score + (1 + s) * shape_score);
    out[i] += by_above + (by_scale * to_scale + by_shape * to_shape) / above;
  }
  return out;
}

/// Log-likelihood of the share above the level, of n values of which m are.
double share_likelihood(double m, double n, double share) { return m * std::log(share) + (n - m) * std::log1p(-share); }

/// The largest quantile, and the largest shape, within the region of the likelihood.
void bound_quantile(const std::vector<Candidate>& places, double n, double share, double confidence, Tail& tail) {
  const auto m = static_cast<double>(tail.exceedances);
  const double t = boost::math::quantile(boost::math::students_t(m / tail.alike - 2), confidence);
  const double slack = t * t / 2 * tail.alike, best_share = share_likelihood(m, n, m / n);
  double most = places.front().likelihood(places.front().mean);
  for (const Candidate& place : places) most = std::max(most, place.likelihood(place.mean));
  for (int part = 0; part <= kShares; ++part) {
    const double left = slack * part / kShares;
    const double above =
        farthest(m / n, best_share - (slack - left), 1 - 1e-9, [&](double at) { return share_likelihood(m, n, at); });
    for (const Candidate& place : places) {
      if (m * (most - place.likelihood(place.mean)) > left) continue;
      const double limit = place.q > 0 ? std::max(kHeaviest, place.mean) : kLeastShape;
      const double shape = farthest(place.mean, most - left / m, limit, [&](double at) { return place.likelihood(at); });
      tail.shape_at_most = std::max(tail.shape_at_most, shape);
      tail.at_most =
          std::max(tail.at_most, quantile({.level = tail.level, .shape = shape, .scale = shape / place.q}, above, share));
    }
  }
}

}  // namespace

std::optional<Tail> tail_of(std::span<const double> values, double share, double confidence) {
  const auto n = static_cast<double>(values.size());
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  std::optional<Tail> widest;
  for (double most = std::min(n / 10, std::pow(n, 2.0 / 3)); most >= kLeastExceedances; most *= kNextLevel) {
    Tail tail{.level = sorted[sorted.size() - 1 - static_cast<std::size_t>(most)]};
    std::vector<double> exceedances;
    for (const double value : sorted) {
      if (value > tail.level) exceedances.push_back(value - tail.level);
    }
    tail.exceedances = std::ssize(exceedances);
    if (static_cast<double>(tail.exceedances) < kLeastExceedances) continue;
    const std::vector<Candidate> places = places_of(exceedances);
    const Candidate best = *std::max_element(places.begin(), places.end(), [](const Candidate& a, const Candidate& b) {
      return a.likelihood(a.mean) < b.likelihood(b.mean);
    });
    tail.shape = tail.shape_at_most = best.mean;
    tail.scale = best.mean / best.q;
    const double above = static_cast<double>(tail.exceedances) / n;
    tail.estimate = tail.at_most = quantile(tail, above, share);
    tail.alike = dispersion(influences(values, tail, above, share));
    if (static_cast<double>(tail.exceedances) < kLeastExceedances * tail.alike) continue;
    if (misfit(exceedances, tail.shape, tail.scale) > fit_limit(tail.shape) * tail.alike) continue;
    bound_quantile(places, n, share, confidence, tail);
    if (!widest || tail.at_most > widest->at_most) widest = tail;
  }
  return widest;
}

}  // namespace evenstep::internal
