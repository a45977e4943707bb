#include "decimal_time.h"

#include <charconv>
#include <chrono>

namespace evenstep::internal {
namespace {

constexpr int kMostDigits = 25;  // 4e18 ns with 6 digits of fraction; with a unit of 1e9 it stays below 2^127

/// The sign, digits, and power of ten of a decimal number.
struct Decimal {
  bool minus = false;
  __int128 digits = 0;
  std::int64_t exponent = 0;
};

/// Reads an exponent after 'e'; false if there is something else.
bool take_exponent(std::string_view text, std::int64_t& exponent) {
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int64_t written = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), written);
  if (error != std::errc() || end != text.data() + text.size() || written < -1000 || written > 1000) return false;
  exponent += written;
  return true;
}

std::optional<Decimal> decimal_of(std::string_view text) {
  Decimal number;
  if (text.starts_with('-') || text.starts_with('+')) {
    number.minus = text.front() == '-';
    text.remove_prefix(1);
  }
  bool any = false, point = false;
  int kept = 0;
  for (; !text.empty(); text.remove_prefix(1)) {
    const char c = text.front();
    if (c == '.' && !point) {
      point = true;
    } else if (c >= '0' && c <= '9') {
      any = true;
      const bool keep = kept < kMostDigits;
      if (!keep && !point) ++number.exponent;
      if (!keep) continue;
      number.digits = 10 * number.digits + (c - '0');
      kept += number.digits != 0;
      number.exponent -= point;
    } else {
      break;
    }
  }
  if (!any || number.exponent < -1000 || number.exponent > 1000) return std::nullopt;
  if (text.empty()) return number;
  if ((text.front() != 'e' && text.front() != 'E') || !take_exponent(text.substr(1), number.exponent)) return std::nullopt;
  return number;
}

}  // namespace

std::optional<std::int64_t> decimal_time_ns(std::string_view text, std::int64_t unit_ns) {
  const std::optional<Decimal> number = decimal_of(text);
  if (!number) return std::nullopt;
  // Below 1e25 * 1e9 = 1e34; a power of ten is only multiplied in while the product stays below 1e35.
  __int128 ns = number->digits * unit_ns;
  std::int64_t exponent = number->exponent;
  for (; exponent > 0 && ns != 0; --exponent) {
    if (ns > kFurthestTime_ns) return std::nullopt;
    ns *= 10;
  }
  int half = 0;  // whether the digit cut last is at least 5
  for (; exponent < 0 && (ns != 0 || half != 0); ++exponent) {
    half = ns % 10 >= 5;
    ns /= 10;
  }
  ns += half;
  if (ns > kFurthestTime_ns) return std::nullopt;
  return static_cast<std::int64_t>(number->minus ? -ns : ns);
}

std::optional<std::int64_t> date_time_ns(std::string_view text) {
  constexpr char kBehind[] = {'-', '-', ' ', ':', ':'};
  constexpr int kLeast[] = {1970, 1, 1, 0, 0}, kMost[] = {2090, 12, 31, 23, 59};
  int parts[5] = {};
  for (int i = 0; i < 5; ++i) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parts[i]);
    const auto used = static_cast<std::size_t>(end - text.data());
    if (error != std::errc() || parts[i] < kLeast[i] || parts[i] > kMost[i] || used == text.size()) return std::nullopt;
    if (text[used] != kBehind[i] && !(i == 2 && text[used] == 'T')) return std::nullopt;
    text.remove_prefix(used + 1);
  }
  if (text.ends_with('Z')) text.remove_suffix(1);
  const std::optional<std::int64_t> second = decimal_time_ns(text, 1'000'000'000);
  if (!second || *second < 0 || *second >= 61'000'000'000) return std::nullopt;
  const std::chrono::sys_days day = std::chrono::year{parts[0]} / parts[1] / parts[2];
  return ((day.time_since_epoch().count() * std::int64_t{24} + parts[3]) * 60 + parts[4]) * 60'000'000'000 + *second;
}

std::optional<std::int64_t> time_unit_ns(std::string_view unit) {
  if (unit == "ns") return 1;
  if (unit == "us" || unit == "\u00b5s" || unit == "\u03bcs") return 1'000;
  if (unit == "ms") return 1'000'000;
  if (unit == "s") return 1'000'000'000;
  return std::nullopt;
}

std::string_view time_unit_text(std::int64_t unit_ns) {
  return unit_ns == 1 ? "ns" : unit_ns == 1'000 ? "us" : unit_ns == 1'000'000 ? "ms" : "s";
}

}  // namespace evenstep::internal
