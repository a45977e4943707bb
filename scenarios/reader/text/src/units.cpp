#include "evenstep/text/units.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <utility>

#include "evenstep/text/suggest.h"

namespace evenstep::internal {
namespace {

constexpr std::array<DimensionInfo, 16> kDimensions{{
    {Dimension::none, "plain number", "1", "0.1"},
    {Dimension::time, "time", "s", "11.1 ms"},
    {Dimension::length, "length", "m", "5 mm"},
    {Dimension::velocity, "velocity", "m/s", "0.1 m/s"},
    {Dimension::acceleration, "acceleration", "m/s2", "-9.81 m/s2"},
    {Dimension::force, "force", "N", "3 N"},
    {Dimension::slew, "force per time", "N/s", "1000 N/s"},
    {Dimension::stiffness, "stiffness", "N/m", "200 N/m"},
    {Dimension::damping, "damping", "N s/m", "0.01 N s/m"},
    {Dimension::energy, "energy", "J", "1 mJ"},
    {Dimension::mass, "mass", "kg", "0.125 g"},
    {Dimension::rate, "rate", "Hz", "30 Hz"},
    {Dimension::ratio, "ratio", "1", "10 %"},
    {Dimension::drift, "ratio per time", "1/s", "10 %/s"},
    {Dimension::angle, "angle", "deg", "900 deg"},
    {Dimension::torque, "torque", "N m", "5 N m"},
}};

/// Names of units that are usual in other tools.
constexpr std::array<std::pair<std::string_view, std::string_view>, 30> kHabits{{
    {"sec", "s"},     {"secs", "s"},          {"second", "s"},    {"seconds", "s"}, {"msec", "ms"},    {"msecs", "ms"},
    {"millis", "ms"}, {"milliseconds", "ms"}, {"usec", "us"},     {"µs", "us"},     {"μs", "us"},      {"µm", "um"},
    {"μm", "um"},     {"nsec", "ns"},         {"minutes", "min"}, {"hours", "h"},   {"percent", "%"},  {"mps", "m/s"},
    {"fps", "Hz"},    {"Ns/m", "N s/m"},      {"N*s/m", "N s/m"}, {"µN", "uN"},     {"m/s^2", "m/s2"}, {"m/s²", "m/s2"},
    {"Nm", "N m"},    {"N*m", "N m"},         {"mNm", "mN m"},    {"°", "deg"},     {"degree", "deg"}, {"degrees", "deg"},
}};

/// Whether the names differ in capital letters only.
bool same_letters(std::string_view name, std::string_view unit) {
  return std::equal(name.begin(), name.end(), unit.begin(), unit.end(),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// Adds one digit to the mantissa; false when 18 digits are full.
bool add_digit(std::int64_t& mantissa, char digit) {
  if (mantissa >= 100'000'000'000'000'000) return false;
  mantissa = mantissa * 10 + (digit - '0');
  return true;
}

/// The exponent of "1e-6". It must be followed by digits, so that "5 eN" is read as a unit.
int take_exponent(std::string_view& text) {
  if (text.empty() || (text[0] != 'e' && text[0] != 'E')) return 0;
  std::size_t at = 1;
  const bool negative = at < text.size() && text[at] == '-';
  if (at < text.size() && (text[at] == '-' || text[at] == '+')) ++at;
  if (at >= text.size() || !is_digit(text[at])) return 0;
  int value = 0;
  for (; at < text.size() && is_digit(text[at]); ++at) value = std::min(value * 10 + (text[at] - '0'), 400);
  text.remove_prefix(at);
  return negative ? -value : value;
}

/// Takes a decimal off the front of `text`; the error is empty if that went well.
std::string take_decimal(std::string_view& text, Decimal& number) {
  const std::string_view whole = text;
  number = {};
  const bool negative = !text.empty() && text.front() == '-';
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
  bool any = false, point = false;
  for (; !text.empty() && (is_digit(text.front()) || (text.front() == '.' && !point)); text.remove_prefix(1)) {
    if (text.front() == '.') {
      point = true;
      continue;
    }
    any = true;
    if (!add_digit(number.mantissa, text.front())) return fmt::format("'{}' has more than 18 digits", whole);
    if (point) --number.exponent;
  }
  if (!any) return fmt::format("'{}' does not begin with a number", whole);
  number.exponent = std::clamp(number.exponent + take_exponent(text), -400, 400);
  while (number.mantissa != 0 && number.mantissa % 10 == 0) {
    number.mantissa /= 10;
    ++number.exponent;
  }
  if (number.mantissa == 0) number.exponent = 0;
  if (negative) number.mantissa = -number.mantissa;
  return {};
}

}  // namespace

const std::vector<Unit>& units() {
  using D = Dimension;
  static const std::vector<Unit> table{
      {"ns", D::time, 1, -9},
      {"us", D::time, 1, -6},
      {"ms", D::time, 1, -3},
      {"s", D::time, 1, 0},
      {"min", D::time, 60, 0},
      {"h", D::time, 3600, 0},
      {"segment", D::time, 1, 0, UnitKind::segment, true},
      {"visualization", D::time, 1, 0, UnitKind::visualization, true},
      {"slot", D::time, 1, 0, UnitKind::slot, true},
      {"step_run_time", D::time, 1, 0, UnitKind::step_run_time, true},
      {"nm", D::length, 1, -9},
      {"um", D::length, 1, -6},
      {"mm", D::length, 1, -3},
      {"cm", D::length, 1, -2},
      {"m", D::length, 1, 0},
      {"um/s", D::velocity, 1, -6},
      {"mm/s", D::velocity, 1, -3},
      {"cm/s", D::velocity, 1, -2},
      {"m/s", D::velocity, 1, 0},
      {"mm/s2", D::acceleration, 1, -3},
      {"m/s2", D::acceleration, 1, 0},
      {"uN", D::force, 1, -6},
      {"mN", D::force, 1, -3},
      {"N", D::force, 1, 0},
      {"kN", D::force, 1, 3},
      {"mN/s", D::slew, 1, -3},
      {"N/s", D::slew, 1, 0},
      {"kN/s", D::slew, 1, 3},
      {"N/ms", D::slew, 1, 3},
      {"N/m", D::stiffness, 1, 0},
      {"N/mm", D::stiffness, 1, 3},
      {"kN/m", D::stiffness, 1, 3},
      {"mN s/m", D::damping, 1, -3},
      {"N s/m", D::damping, 1, 0},
      {"uJ", D::energy, 1, -6},
      {"mJ", D::energy, 1, -3},
      {"J", D::energy, 1, 0},
      {"ug", D::mass, 1, -9},
      {"mg", D::mass, 1, -6},
      {"g", D::mass, 1, -3},
      {"kg", D::mass, 1, 0},
      {"mHz", D::rate, 1, -3},
      {"Hz", D::rate, 1, 0},
      {"kHz", D::rate, 1, 3},
      {"%", D::ratio, 1, -2},
      {"ppm", D::ratio, 1, -6},
      {"%/s", D::drift, 1, -2},
      {"deg", D::angle, 1, 0},
      {"turn", D::angle, 360, 0, UnitKind::plain, true},
      {"mN m", D::torque, 1, -3},
      {"N m", D::torque, 1, 0},
  };
  return table;
}

const DimensionInfo& info(Dimension dimension) {
  return *std::find_if(kDimensions.begin(), kDimensions.end(),
                       [&](const DimensionInfo& i) { return i.dimension == dimension; });
}

const DimensionInfo* info_of_base(std::string_view base) {
  const auto found =
      std::find_if(kDimensions.begin(), kDimensions.end(), [&](const DimensionInfo& i) { return i.base == base; });
  return found == kDimensions.end() ? nullptr : &*found;
}

const Unit* find_unit(std::string_view name) {
  for (const Unit& unit : units()) {
    if (unit.name == name) return &unit;
    if (unit.word && name.size() == unit.name.size() + 1 && name.back() == 's' &&
        name.substr(0, unit.name.size()) == unit.name)
      return &unit;
  }
  return nullptr;
}

namespace {

/// Whether this is a unit of here with the prefix for millions, such as "MHz", which only its capital letter tells from
/// "mHz".
bool is_mega(std::string_view name) {
  return name.size() > 1 && name.front() == 'M' && find_unit(name.substr(1)) != nullptr &&
         find_unit(fmt::format("m{}", name.substr(1))) != nullptr;
}

}  // namespace

std::string not_a_unit(std::string_view name, Dimension wanted) {
  if (const Unit* other = find_unit(name); other && other->dimension != wanted) {
    return fmt::format("'{}' is a unit of {}, not of {}", name, info(other->dimension).name, info(wanted).name);
  }
  const bool any = wanted == Dimension::none;
  std::vector<std::string_view> known;
  if (any) known.push_back("step");
  for (const Unit& unit : units()) {
    if (any || unit.dimension == wanted) known.push_back(unit.name);
  }
  std::string_view meant;
  for (const std::string_view unit : known) {
    if (same_letters(name, unit)) meant = unit;
    for (const auto& [habit, proper] : kHabits) {
      if (habit == name && proper == unit) meant = unit;
    }
  }
  std::string hint = meant.empty() ? suggestion(name, known) : fmt::format("; did you mean '{}'?", meant);
  if (is_mega(name)) hint = fmt::format("; there is no prefix for millions here, known: {}", fmt::join(known, ", "));
  for (const Unit& other : units()) {  // "30 hz" where a time is wanted, or a rate
    if (!any && meant.empty() && other.dimension != wanted && same_letters(name, other.name))
      hint = fmt::format("; '{}' is a unit of {}", other.name, info(other.dimension).name);
  }
  return any ? fmt::format("'{}' is not a unit{}", name, hint)
             : fmt::format("'{}' is not a unit of {}{}", name, info(wanted).name, hint);
}

NumberAndUnit split_number(std::string_view text) {
  NumberAndUnit out;
  std::string_view rest = trimmed(text);
  out.error = take_decimal(rest, out.number);
  if (!out.error.empty()) return out;
  if (!rest.empty() && rest.front() == '/') {
    rest.remove_prefix(1);
    out.divisor = {};
    out.error = take_decimal(rest, out.divisor);
    if (out.error.empty() && out.divisor.mantissa <= 0) out.error = fmt::format("'{}' divides by zero or less", text);
  }
  if (out.error.empty() && !rest.empty() && rest.front() == ',')
    out.error = fmt::format("'{}' has a comma, and the decimal mark is a point", text);
  out.unit = trimmed(rest);
  return out;
}

double to_double(Decimal number) {
  const std::string digits = fmt::format("{}e{}", number.mantissa, number.exponent);
  double value = 0;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (result.ec == std::errc::result_out_of_range) {
    // Outside the range of doubles: more than any range of the field table allows, or 0.
    if (number.exponent < 0) return 0;
    return number.mantissa < 0 ? -1e300 : 1e300;
  }
  return value;
}

}  // namespace evenstep::internal
