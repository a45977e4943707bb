// Any bytes as a report descriptor. It is parsed or refused. Every field of what was parsed is set and read, and so is the
// layout that a PID device would have.
#include <algorithm>
#include <cmath>

#include "evenstep/device/hid/pid_layout.h"
#include "evenstep/device/hid/report_descriptor.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr std::size_t kLongestReport = 16'384;

void require_sound(const ReportDescriptor& descriptor, const HidField& field) {
  const HidReport* report = descriptor.report(field.type, field.id);
  require(report != nullptr, "a field of no report");
  require(field.bit_offset + field.bits * field.count <= report->bits, "a field reaches past its report");
  require(report->size() <= kLongestReport, "a report is too long");
  require(field.usages.size() >= 1, "an element without a usage");
  for (const std::uint32_t place : {0u, field.usages.size() - 1}) {
    const auto first = field.usages.find(field.usages[place]);
    require(first && *first <= place, "a usage that is not found");
  }
  require(field.logical_minimum <= field.logical_maximum, "an empty logical range");
  require(field.collection < static_cast<std::int32_t>(descriptor.collections.size()), "a field in no known collection");
}

void set_and_get(std::span<std::byte> report, const HidField& field, std::uint32_t index) {
  const bool addressable = field.bits >= 1 && field.bits <= 32;
  require(get(report, field, index).has_value() == addressable, "an element of the report cannot be got");
  for (const std::int64_t wanted : {field.logical_minimum, field.logical_maximum, std::int64_t{0}}) {
    const auto value = nearest(field, wanted);
    if (!addressable || !value) continue;
    require(set(report, field, index, *value) && get(report, field, index) == value, "a value does not read back");
    const double physical = to_physical(field, *value);
    require(!std::isnan(physical), "a physical value is not a number");
    const auto back = to_logical(field, physical);
    require(!back || can_hold(field, *back), "a logical value does not fit");
    if (const auto usage = selected(field, *value))
      require(selector(field, *usage).has_value(), "a selected usage cannot be selected");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto parsed = parse_report_descriptor(std::as_bytes(std::span(data, size)));
  if (!parsed) {
    require(!parsed.error().message.empty(), "an error without words");
    require(parsed.error().offset <= size, "an error outside the descriptor");
    return 0;
  }
  const auto pid = pid_layout(*parsed);
  require(pid || !pid.error().empty(), "neither a layout nor what is missing");
  std::vector<std::byte> bytes(kLongestReport);
  for (const HidField& field : parsed->fields) {
    require_sound(*parsed, field);
    const auto report = std::span(bytes).first(parsed->report(field.type, field.id)->size());
    for (const std::uint32_t index : {0u, field.count / 2, field.count - 1}) {
      if (index < field.count) set_and_get(report, field, index);
    }
  }
  return 0;
}
