#include "evenstep/text/option_values.h"

#include <fmt/format.h>

#include <algorithm>

namespace evenstep {

Result<Rate> parse_period_or_rate(const std::string& text) {
  const Result<Rate> rate = parse_rate(text);
  if (rate) return *rate;
  const Result<Duration> period = parse_duration(text);
  if (period && period->ns > 0 && period->ns <= 1'000'000'000) return Rate{1'000'000'000, period->ns};
  return Failure(fmt::format("\"{}\" is no period of at most 1 s, such as \"1 ms\", and no rate, such as \"1 kHz\"", text));
}

Result<double> parse_share(const std::string& text) {
  const Result<double> share = parse_si(text, Dimension::ratio);
  if (!share || (*share > 0 && *share < 1)) return share;
  return Failure(fmt::format("\"{}\" must be above 0 % and below 100 %", text));
}

Result<double> parse_above_zero(const std::string& text, Dimension dimension, const char* unit) {
  const Result<double> value = parse_si(text, dimension);
  if (!value || *value > 0) return value;
  return Failure(fmt::format("must be above 0 {}", unit));
}

Result<Duration> parse_span(const std::string& text) {
  constexpr double kLongest_s = 9e9;
  const Result<double> span = parse_above_zero(text, Dimension::time, "h");
  if (!span) return Failure(span.error());
  return Duration{static_cast<std::int64_t>(std::min(*span, kLongest_s) * 1e9)};
}

}  // namespace evenstep
