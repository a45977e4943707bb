#include "drivers.h"

#include <fmt/format.h>

#include <utility>

#include "field_rows.h"
#include "sections.h"

namespace evenstep {
using namespace internal;

std::vector<Field> ReferenceSpec::fields() { return {}; }
ReferenceSpec ReferenceSpec::read(const ScenarioReading&, const Table&) { return {}; }

std::vector<Field> ForeignDriverSpec::fields() {
  const std::vector<Field> rows{driver_table_row("foreign", "Which driver that is not evenstep's own, and what it takes.")};
  return joined(joined(rows, library_rows("device", "foreign")), foreign_rows("device.foreign", ""));
}
ForeignDriverSpec ForeignDriverSpec::read(const ScenarioReading& reading, const Table& device) {
  ForeignDriverSpec spec{read_foreign(reading, device.table("foreign")), {}};
  spec.make = maker_of("driver", spec.part, reading.registry.devices(), &Library::device, reading.errors);
  for (const char* key :
       {"queue", "unplug", "returns", "faults", "sample_time", "report_age", "report_age_jitter", "clock_rate_error"}) {
    if (device.has(key))
      reading.errors.add(device.place(key),
                         fmt::format("'{}' is about reports on a cable, and driver = \"foreign\" has none that evenstep "
                                     "knows; remove it, or pass it to the driver in its options",
                                     key));
  }
  return spec;
}

namespace {

template <class Spec>
std::optional<OwnSprings> springs_of(const Spec& spec) {
  if constexpr (requires { steepest_spring_N_per_m(spec.options); }) {
    OwnSprings springs{{}, spec.firmware_rate};
    if (spec.knows_newtons()) springs.steepest_N_per_m = steepest_spring_N_per_m(spec.options);
    return springs;
  } else {
    return std::nullopt;
  }
}

}  // namespace

std::optional<OwnSprings> own_springs(const DriverSpec& driver) {
  return std::visit([](const auto& spec) { return springs_of(spec); }, driver);
}

namespace internal {
namespace {

template <class Spec>
std::string no_return(const Spec&) {
  if constexpr (requires { Spec::kNoReturn; })
    return fmt::format("driver = \"{}\" {}; remove it", Spec::kName, Spec::kNoReturn);
  else
    return {};
}

template <class Spec>
DriverFormat format_of() {
  return {Spec::kName, Spec::fields,
          [](const ScenarioReading& reading, const Table& device) -> DriverSpec { return Spec::read(reading, device); }};
}

template <std::size_t... i>
std::vector<DriverFormat> formats_of(std::index_sequence<i...>) {
  return {format_of<std::variant_alternative_t<i, DriverSpec>>()...};
}

}  // namespace

const std::vector<DriverFormat>& driver_formats() {
  static const std::vector<DriverFormat> formats = formats_of(std::make_index_sequence<std::variant_size_v<DriverSpec>>());
  return formats;
}

std::string why_no_return(const DriverSpec& driver) {
  return std::visit([](const auto& spec) { return no_return(spec); }, driver);
}

std::string_view driver_words() {
  static const std::string words = words_of(driver_formats(), [](const DriverFormat& driver) { return driver.name; });
  return words;
}

const std::vector<Field>& driver_fields() {
  static const std::vector<Field> rows = [] {
    std::vector<Field> all;
    for (const DriverFormat& driver : driver_formats()) {
      const std::vector<Field> own = driver.fields();
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }();
  return rows;
}

}  // namespace internal
}  // namespace evenstep
