#pragma once
/// Values as options have them, in a command or in a call: exact as in quantity.h, and within what makes sense. Each error
/// says what was expected.

#include <string>

#include "evenstep/text/quantity.h"

namespace evenstep {

/// A rate, or a period of at most 1 s.
Result<Rate> parse_period_or_rate(const std::string& text);
/// Above 0 % and below 100 %.
Result<double> parse_share(const std::string& text);
/// Above 0, in SI base units; `unit` is what the error calls it in.
Result<double> parse_above_zero(const std::string& text, Dimension dimension, const char* unit);
/// Above 0 s; what is longer than 285 years is as long as that, which 64 bits of nanoseconds can hold.
Result<Duration> parse_span(const std::string& text);

}  // namespace evenstep
