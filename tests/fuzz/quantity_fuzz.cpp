// Any bytes as a value with a unit. If it is read as a time or rate, its exact value must be read as the same.
#include <cmath>

#include "evenstep/text/quantity.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr std::int64_t kLongest_ns = 1'000'000'000'000'000;  // 1e6 s, as documented

void check_duration(std::string_view text) {
  const NominalUnits nominal{{33'333'333}, {11'100'000}, {2'222'222}, {1'482'222}, true};
  for (const NominalUnits& units : {NominalUnits{}, nominal}) {
    const Result<Duration> parsed = parse_duration(text, units);
    if (!parsed.ok()) continue;
    require(std::abs(parsed->ns) <= kLongest_ns, "longer than 1e6 s");
    const Result<Duration> again = parse_duration(std::to_string(parsed->ns) + " ns", units);
    require(again.ok() && *again == *parsed, "a duration does not read back: " + again.error_or(""));
  }
}

void check_rate(std::string_view text) {
  const Result<Rate> parsed = parse_rate(text);
  if (!parsed.ok()) return;
  const Rate rate = *parsed;
  require(rate.num > 0 && rate.den > 0, "a rate is not above 0");
  require(instant_ns(rate, 1) >= 1, "a period is shorter than 1 ns");
  const Result<Rate> again = parse_rate(std::to_string(rate.num) + "/" + std::to_string(rate.den) + " Hz");
  require(again.ok() && again->num == rate.num && again->den == rate.den,
          "a rate does not read back: " + again.error_or(""));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  check_duration(text);
  check_rate(text);
  // Only one dimension per input, because the search for the unit that was meant takes most of the time.
  const auto dimension = static_cast<Dimension>(size % (static_cast<std::size_t>(Dimension::slew) + 1));
  const Result<double> parsed = parse_si(text, dimension);
  require(!parsed.ok() || !std::isnan(*parsed), "a value is not a number");
  const Result<Limit> limit = parse_limit(text);
  require(!limit.ok() || !std::isnan(limit->number), "a limit is not a number");
  return 0;
}
