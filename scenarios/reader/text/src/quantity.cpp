#include "evenstep/text/quantity.h"

#include <fmt/format.h>

#include <cmath>

#include "evenstep/text/rational.h"
#include "evenstep/text/units.h"

namespace evenstep {
namespace {

using internal::Decimal;
using internal::Unit;
using internal::UnitKind;

constexpr __int128 kNsPerSecond = 1'000'000'000;
constexpr std::int64_t kLongest_ns =
    1'000'000'000'000'000;  // 1e6 s, so that sums of a few times are far from the int64 limit

__int128 power_of_ten(int exponent) {
  __int128 power = 1;
  for (int i = 0; i < exponent; ++i) power *= 10;
  return power;
}

const Duration* nominal_length(const NominalUnits& nominal, UnitKind kind) {
  switch (kind) {
    case UnitKind::segment:
      return &nominal.segment;
    case UnitKind::visualization:
      return &nominal.visualization;
    case UnitKind::slot:
      return &nominal.slot;
    case UnitKind::step_run_time:
      return &nominal.step_run_time;
    case UnitKind::plain:
      break;
  }
  return nullptr;
}

/// number * unit_ns, rounded down; `exact` is false if that changed the value. |result| is limited to a little over 1e6 s.
struct WholeNs {
  std::int64_t ns = 0;
  bool exact = true;
};
WholeNs whole_ns(Decimal number, __int128 unit_ns) {
  constexpr std::int64_t kTooLong = kLongest_ns + 1;
  const bool negative = number.mantissa < 0;
  if (number.mantissa == 0 || unit_ns == 0) return {};
  if (number.exponent > 15) return {negative ? -kTooLong : kTooLong};  // >= 1e16 units of at least 1 ns
  // |mantissa| < 1e18 and unit_ns <= 3.6e12 (an hour): the product stays below 3.6e30 < 2^127.
  __int128 product = static_cast<__int128>(number.mantissa) * unit_ns;
  WholeNs out;
  if (number.exponent < 0) {
    if (number.exponent < -37) return {negative ? -1 : 0, false};
    const __int128 divisor = power_of_ten(-number.exponent);
    out.exact = product % divisor == 0;
    product = product / divisor - (!out.exact && negative ? 1 : 0);
  } else {
    for (int i = 0; i < number.exponent && product < kTooLong && product > -kTooLong; ++i) product *= 10;
  }
  if (product > kTooLong) product = kTooLong;
  if (product < -kTooLong) product = -kTooLong;
  out.ns = static_cast<std::int64_t>(product);
  return out;
}

/// The unit of `wanted`, or the error.
Result<const Unit*> unit_of(const internal::NumberAndUnit& split, std::string_view text, Dimension wanted) {
  const internal::DimensionInfo& dimension = internal::info(wanted);
  if (!split.error.empty())
    return Failure(fmt::format("{}; write a {} such as \"{}\"", split.error, dimension.name, dimension.example));
  if (split.unit.empty()) {
    return Failure(fmt::format("'{}' has no unit; write a {} such as \"{}\"", text, dimension.name, dimension.example));
  }
  const Unit* unit = internal::find_unit(split.unit);
  if (unit == nullptr || unit->dimension != wanted) return Failure(internal::not_a_unit(split.unit, wanted));
  return unit;
}

bool is_fraction(const internal::NumberAndUnit& split) { return split.divisor.mantissa != 1 || split.divisor.exponent != 0; }

/// number * 10^exponent * scale / divisor, where `number` stands for the shortest decimal that reads as it: what a user
/// wrote with at most 15 digits, and any time in whole ns. Rounded once if scale or divisor is 1 and the digits fit.
double scaled(double number, int exponent, std::int64_t scale, std::int64_t divisor) {
  const Decimal decimal = internal::split_number(fmt::format("{}", number)).number;
  const int shifted = decimal.exponent + exponent;
  std::int64_t product = 0;
  if (__builtin_mul_overflow(decimal.mantissa, scale, &product))
    return internal::to_double({decimal.mantissa, shifted}) * static_cast<double>(scale);
  return internal::to_double({product, shifted}) / static_cast<double>(divisor);
}

const char* const kOnlyRatesAreFractions = "only a rate may be a fraction; write a decimal number";

}  // namespace

Result<Duration> parse_duration(std::string_view text, const NominalUnits& nominal) {
  const internal::NumberAndUnit split = internal::split_number(text);
  const Result<const Unit*> unit = unit_of(split, text, Dimension::time);
  if (!unit) return Failure(unit.error());
  if (is_fraction(split)) return Failure(fmt::format("'{}': {}", text, kOnlyRatesAreFractions));

  WholeNs value;
  if (const Duration* length = nominal_length(nominal, (*unit)->kind)) {
    if (!nominal.known)
      return Failure(fmt::format("'{}' is not known here: [timing] itself defines it; write the time in ms", split.unit));
    value = whole_ns(split.number, length->ns);  // nominal times are rounded down themselves, so this is no error
  } else {
    Decimal number = split.number;
    number.exponent += (*unit)->exponent;
    value = whole_ns(number, (*unit)->scale * kNsPerSecond);
    if (!value.exact) return Failure(fmt::format("'{}' is finer than 1 ns, the resolution of time here", text));
  }
  if (value.ns > kLongest_ns || value.ns < -kLongest_ns)
    return Failure(fmt::format("'{}' is longer than 1e6 s, the longest time here", text));
  return Duration{value.ns};
}

Result<Rate> parse_rate(std::string_view text) {
  const internal::NumberAndUnit split = internal::split_number(text);
  const Result<const Unit*> unit = unit_of(split, text, Dimension::rate);
  if (!unit) return Failure(unit.error());
  if (split.number.mantissa <= 0) return Failure(fmt::format("'{}' is not above 0 Hz", text));

  // 1 uHz .. 1 GHz (a period of 1 ns); the numerator up to 1e18, and every denominator that reduced_rate gives.
  const int exponent = split.number.exponent + (*unit)->exponent - split.divisor.exponent;
  const std::string out_of_range = fmt::format("'{}' is not between 1 uHz and 1 GHz with at most 9 decimals", text);
  if (exponent > 18 || exponent < -18) return Failure(out_of_range);
  __int128 num = split.number.mantissa, den = split.divisor.mantissa;
  __int128& scaled = exponent < 0 ? den : num;
  scaled *= power_of_ten(exponent < 0 ? -exponent : exponent);
  const __int128 divisor = internal::greatest_common_divisor(num, den);
  num /= divisor;
  den /= divisor;
  constexpr __int128 kGiga = 1'000'000'000;
  if (den > internal::kMostRateDen || num > kGiga * kGiga || num > den * kGiga || num * 1'000'000 < den)
    return Failure(out_of_range);
  return Rate{static_cast<std::int64_t>(num), static_cast<std::int64_t>(den)};
}

Result<double> parse_si(std::string_view text, Dimension dimension) {
  const internal::NumberAndUnit split = internal::split_number(text);
  if (split.error.empty() && is_fraction(split)) return Failure(fmt::format("'{}': {}", text, kOnlyRatesAreFractions));
  if (dimension == Dimension::none) {
    if (!split.error.empty()) return Failure(split.error);
    if (!split.unit.empty()) return Failure(fmt::format("'{}': a plain number has no unit", text));
    return internal::to_double(split.number);
  }
  const Result<const Unit*> unit = unit_of(split, text, dimension);
  if (!unit) return Failure(unit.error());
  if ((*unit)->kind != UnitKind::plain)
    return Failure(fmt::format("'{}' is a nominal time; write the time in ms", split.unit));
  const Decimal scaled{split.number.mantissa, split.number.exponent + (*unit)->exponent};
  return internal::to_double(scaled) * static_cast<double>((*unit)->scale);
}

Result<Limit> parse_limit(std::string_view text) {
  const internal::NumberAndUnit split = internal::split_number(text);
  if (!split.error.empty()) return Failure(fmt::format("{}; write a limit such as \"4 step\", \"12 ms\" or 0", split.error));
  if (is_fraction(split)) return Failure(fmt::format("'{}': {}", text, kOnlyRatesAreFractions));
  const bool step = split.unit == "step" || split.unit == "steps";
  if (!split.unit.empty() && !step && internal::find_unit(split.unit) == nullptr) {
    return Failure(internal::not_a_unit(split.unit, Dimension::none));
  }
  return Limit{internal::to_double(split.number), step ? "step" : std::string(split.unit)};
}

Result<double> unit_factor(std::string_view unit, std::string_view base, double step_value, const NominalUnits& nominal) {
  if (base == "count") base = "1";
  if (unit.empty() || unit == base) {
    if (base == "1" || unit == base) return 1.0;
    return Failure(fmt::format("a limit on '{}' needs a unit, such as '{}'", base, base));
  }
  if (unit == "step") {
    if (base != "m" && base != "N") return Failure(fmt::format("'step' measures a length or a force, not '{}'", base));
    if (!(step_value > 0))
      return Failure("'step' has no value here: it needs a motion with a nominal speed (and, for force, a stiffness)");
    return step_value;
  }
  const Dimension wanted = base == "1"                    ? Dimension::ratio
                           : internal::info_of_base(base) ? internal::info_of_base(base)->dimension
                                                          : Dimension::none;
  const Unit* found = internal::find_unit(unit);
  if (found == nullptr || found->dimension != wanted) return Failure(internal::not_a_unit(unit, wanted));
  if (const Duration* length = nominal_length(nominal, found->kind)) {
    if (!nominal.known) return Failure(fmt::format("'{}' is not known here", unit));
    return seconds(*length);
  }
  return internal::to_double({found->scale, found->exponent});
}

Result<double> in_base(const Limit& limit, std::string_view base, double step_value, const NominalUnits& nominal) {
  const Result<double> factor = unit_factor(limit.unit, base, step_value, nominal);
  const Unit* unit = internal::find_unit(limit.unit);
  if (!factor || unit == nullptr || limit.unit == base || !std::isfinite(limit.number))
    return factor ? Result<double>(limit.number * *factor) : factor;
  if (const Duration* length = nominal_length(nominal, unit->kind))
    return limit.number * static_cast<double>(length->ns) / 1e9;  // of a whole number the product is exact
  return scaled(limit.number, unit->exponent, unit->scale, 1);
}

Result<double> in_unit(double base_value, std::string_view unit_name, std::string_view base, double step_value,
                       const NominalUnits& nominal) {
  const Result<double> factor = unit_factor(unit_name, base, step_value, nominal);
  const Unit* unit = internal::find_unit(unit_name);
  if (!factor || unit == nullptr || unit_name == base || !std::isfinite(base_value))
    return factor ? Result<double>(base_value / *factor) : factor;
  if (const Duration* length = nominal_length(nominal, unit->kind)) return scaled(base_value, 9, 1, length->ns);
  return scaled(base_value, -unit->exponent, 1, unit->scale);
}

}  // namespace evenstep
