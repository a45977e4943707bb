#include <fmt/format.h>

#include "size_conclusion.h"

namespace evenstep {
namespace {

using internal::ms;

std::string text(const SizeRange& range) {
  if (range.least == range.most) return fmt::format("{:.6g} ms", ms(range.least));
  return fmt::format("{:.6g} to {:.6g} ms", ms(range.least), ms(range.most));
}

std::string schedules(const SizeWithin& within) {
  std::string out =
      fmt::format("Every schedule of drawings of {} and steps of {}", text(within.visualization), text(within.step));
  if (within.step_size)
    return out + fmt::format(", back to back;\n  frames run the steps of {:.6g} ms that are due when they begin\n",
                             ms(*within.step_size));
  const SizeCounts& steps = *within.steps;
  return out + fmt::format(", {} after each drawing, back to back\n",
                           steps.least == steps.most ? fmt::format("{}", steps.most)
                                                     : fmt::format("{} to {}", steps.least, steps.most));
}

std::string meaning(const SizeWithin::Map& map) {
  switch (map.how) {
    case SizeWithin::How::exact:
      return "exact: enough for all of them, and one needs as much";
    case SizeWithin::How::bound:
      return "a bound: enough for all of them";
    case SizeWithin::How::found:
      break;
  }
  return fmt::format("found, not proved: the worst of {} schedules", map.tried);
}

}  // namespace

const char* name_of(SizeWithin::How how) {
  constexpr const char* kNames[] = {"exact", "bound", "found"};
  return kNames[static_cast<int>(how)];
}

std::string size_within_text(const SizeWithin& within) {
  std::string out =
      schedules(within) + fmt::format("  device period {:.6g} ms at any phase, forces {}\n\n", ms(within.sampling_period),
                                      within.interpolated ? "interpolated" : "held");
  out += fmt::format("  {:<13} {:>13} {:>13} {:>17}\n", "", "latency, ms", "lead, ms", "samples, forces");
  for (const SizeWithin::Map& map : within.maps)
    out += fmt::format("  {:<13} {:>13.6f} {:>13.6f} {:>17}   {}\n", map.name, ms(map.latency), ms(map.lead),
                       fmt::format("{}, {}", map.interaction_capacity, map.force_capacity), meaning(map));
  return out + "  A schedule by itself may need less: lead, latency and rings are for all of them.\n";
}

}  // namespace evenstep
