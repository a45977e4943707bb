#pragma once
/// Values with units, parsed exactly: "11.1 ms" -> 11 100 000 ns, "30 Hz" -> {30, 1}, "1/3 Hz" -> {1, 3}. A value that must
/// be an integer is never computed in double. Unit table: docs/reference/scenario-format.md. Plurals ("segments") are
/// accepted.

#include <string>
#include <string_view>

#include "evenstep/time/result.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// The lengths that [timing] gives; a scenario can use them as units of time ("8 segments", "1 visualization").
struct NominalUnits {
  Duration segment, visualization, slot, step_run_time;
  bool known = false;
};

/// The error says what was expected: "a duration such as \"11.1 ms\"; 'msec' is not a unit of time".
/// |t| <= 1e6 s; a value that is not a whole number of ns is an error.
Result<Duration> parse_duration(std::string_view text, const NominalUnits& nominal = {});
Result<Rate> parse_rate(std::string_view text);  ///< Hz, kHz; > 0
enum class Dimension {
  none,
  time,
  length,
  velocity,
  acceleration,
  force,
  stiffness,
  damping,
  mass,
  rate,
  ratio,
  energy,
  drift,
  angle,
  torque,
  slew
};
/// The value in SI base units: m, m/s, m/s2, N, N/s (slew), N/m, N s/m, kg, J; "10 %" = 0.1, "10 %/s" = 0.1 (drift); N m
/// (torque); degrees (angle), because radians are no exact multiple; a bare number for Dimension::none.
Result<double> parse_si(std::string_view text, Dimension dimension);

/// A limit of an expectation, with number and unit as written; the unit `step` and the nominal times are resolved only when
/// the expectation is judged.
struct Limit {
  double number = 0;
  std::string unit;
};
Result<Limit> parse_limit(std::string_view text);
/// The factor from `unit` to the base unit ("s", "m", "N", "1"): 1e-3 for "ms" in "s". step_value: the value of the unit
/// "step" here; 0 if that unit has no value here.
Result<double> unit_factor(std::string_view unit, std::string_view base, double step_value, const NominalUnits& nominal);
/// The limit in the base unit, rounded once: "12.03 ms" is exactly seconds(12 030 000 ns), and "7 %" exactly 7.0 / 100. A
/// value in the base unit is compared with this. Errors as of unit_factor.
Result<double> in_base(const Limit& limit, std::string_view base, double step_value, const NominalUnits& nominal);
/// A value in the base unit as a number of `unit`, rounded once, for display. Errors as of unit_factor.
Result<double> in_unit(double base_value, std::string_view unit, std::string_view base, double step_value,
                       const NominalUnits& nominal);

}  // namespace evenstep
