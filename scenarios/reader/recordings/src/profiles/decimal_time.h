#pragma once
/// A time as a profiler writes it, exactly in ns: "1712195495505583.25" us is 1712195495505583250 ns, where a double would
/// be 250 ns off.

#include <cstdint>
#include <optional>
#include <string_view>

namespace evenstep::internal {

/// Readers refuse times further than this from zero, so that no difference of two overflows (127 years).
inline constexpr std::int64_t kFurthestTime_ns = 4'000'000'000'000'000'000;

/// `unit_ns` is one unit in ns (1'000 for us, 100 for ticks of 10 MHz). What is below a ns is rounded to the nearest, halves
/// away from zero. Empty if the text is no decimal number (a sign, a fraction and an exponent are), or is further than
/// kFurthestTime_ns.
std::optional<std::int64_t> decimal_time_ns(std::string_view text, std::int64_t unit_ns);

/// "2026-5-1 9:05:03.123456789" in ns since 1970; empty for another text. Only whole days, hours and minutes are looked at
/// for their range.
std::optional<std::int64_t> date_time_ns(std::string_view text);

/// "ns", "us" (also with the Greek letter), "ms", "s" in ns; empty for another word.
std::optional<std::int64_t> time_unit_ns(std::string_view unit);
/// The other way round.
std::string_view time_unit_text(std::int64_t unit_ns);

}  // namespace evenstep::internal
