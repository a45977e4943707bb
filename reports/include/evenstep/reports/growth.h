#pragma once
/// Whether an error grows as a run gets longer: its RMS in the bins of a run (measures.h) is compared with t^p, where t is
/// the time since the run began. docs/reference/metrics.md, "Growth", says what was assumed and how often a name is wrong.

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace evenstep {

/// All exponents p in [0, 5] that the bins do not rule out lie in [low, high] (95 %).
struct GrowthInterval {
  double low = 0, high = 0;
};

/// "bounded" (p = 0), "square root" (1/2) or "linear" (1), if the interval contains this exponent alone, neither of the
/// other two and nothing from 2 on. Otherwise "undetermined".
const char* growth_name(const GrowthInterval& interval);
/// The name and the interval: "linear (0.9 to 1.1)".
std::string growth_text(const GrowthInterval& interval);

/// The fit for bins whose middles lie at `t_s` (s, increasing, above 0).
class GrowthFit {
 public:
  explicit GrowthFit(std::vector<double> t_s);

  /// `rms`: the error in each of the bins, >= 0. Empty if there are fewer than ten bins, or if a value is not finite.
  std::optional<GrowthInterval> operator()(std::span<const double> rms) const;

 private:
  std::vector<double> around_curves(const std::vector<double>& logs) const;
  struct Shape {
    double exponent = 0;
    std::vector<double> logarithm;  ///< of the shape at each bin, minus their mean
  };
  std::vector<double> t_s_;
  std::vector<Shape> shapes_;
};

}  // namespace evenstep
