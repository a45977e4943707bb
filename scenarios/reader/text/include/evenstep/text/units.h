#pragma once
/// The unit table and exact decimals. value = mantissa * 10^exponent, unit = scale * 10^exponent of its base unit.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/text/quantity.h"

namespace evenstep::internal {

enum class UnitKind {
  plain,    ///< a fixed multiple of the base unit
  segment,  ///< nominal times of [timing]
  visualization,
  slot,
  step_run_time,
};

struct Unit {
  std::string_view name;
  Dimension dimension;
  std::int64_t scale;  ///< whole: 1, 60, 3600
  int exponent;        ///< "ms": 1 * 10^-3 s
  UnitKind kind = UnitKind::plain;
  bool word = false;  ///< a word, which may take a plural s
};

const std::vector<Unit>& units();
/// The name of a dimension, its base unit and an example for messages: "time", "s", "\"11.1 ms\"".
struct DimensionInfo {
  Dimension dimension;
  std::string_view name, base, example;
};
const DimensionInfo& info(Dimension dimension);
const DimensionInfo* info_of_base(std::string_view base);

/// The unit with this name ("segments" finds segment), or nullptr.
const Unit* find_unit(std::string_view name);
/// The message "'msec' is not a unit of time; did you mean 'ms'?" or "'Hz' is a unit of rate, not of time". With
/// Dimension::none any unit would do.
std::string not_a_unit(std::string_view name, Dimension wanted);

/// An exact decimal number.
struct Decimal {
  std::int64_t mantissa = 0;  ///< |mantissa| < 10^18
  int exponent = 0;           ///< |exponent| <= 400
};

/// " -1.5e-3 kHz " -> {-15, -4} and "kHz". It is an error if there is no number, if it is NaN or infinity, or if it has more
/// than 18 digits.
struct NumberAndUnit {
  Decimal number;
  Decimal divisor{1, 0};  ///< 3 for "1/3 Hz"; otherwise 1
  std::string_view unit;
  std::string error;
};
NumberAndUnit split_number(std::string_view text);
/// The nearest double: rounded once, in a single conversion.
double to_double(Decimal number);

}  // namespace evenstep::internal
