#include <fmt/format.h>

#include <algorithm>

#include "size_conclusion.h"

namespace evenstep::internal {
namespace {

constexpr int kMapWidth = 17;

std::string heads(const SizeRecord& record, std::size_t width) {
  std::string names, units;
  for (const SizeWhatIf::Map& map : record.what_ifs.front().maps) {
    names += fmt::format(" {:>{}}", map.name, kMapWidth);
    units += fmt::format(" {:>{}}", "latency ms, jump", kMapWidth);
  }
  return fmt::format("  {:<{}}{} {:>9} {:>19} {:>17} {:>11}\n  {:<{}}{} {:>9} {:>9} {:>9} {:>8} {:>8} {:>11}\n", "", width,
                     names, "bound", "drawings", "longest, ms", "simulated", "", width, units, "ms", "a second", "left out",
                     "pause", "without", "over real");
}

std::string row(const SizeWhatIf& one, std::size_t width) {
  const std::string name = one.causal ? "  looking back" : one.text;
  if (!one.refused.empty()) return fmt::format("  {:<{}}  {}\n", name, width, one.refused);
  std::string out = fmt::format("  {:<{}}", name, width);
  for (const SizeWhatIf::Map& map : one.maps) {
    const std::string jump = map.jump_seen ? fmt::format("{:.3f}", map.velocity_jump) : "-";
    out += fmt::format(" {:>{}}", fmt::format("{:.3f}, {}", ms(map.latency), jump), kMapWidth);
  }
  return out + fmt::format(" {:>9.3f} {:>9.4g} {:>9} {:>8.4g} {:>8.4g} {:>11.4f}\n", ms(one.pause_bound), one.drawings_per_s,
                           one.left_out, ms(one.longest_pause), ms(one.longest_without), one.simulated_against_real);
}

/// What not every row has: the pace, pauses over the budget, the latency for an accepted rate, the adaptive latency.
std::string more(const SizeRecord& record, const SizeWhatIf& one) {
  std::string parts;
  const auto add = [&](const std::string& part) { parts += (parts.empty() ? "" : "; ") + part; };
  if (one.pace) add(fmt::format("a pace of {:.6f} ms", ms(*one.pace)));
  if (one.over_budget > 0) add(fmt::format("{} pauses over the budget", one.over_budget));
  for (const SizeWhatIf::Map& map : one.maps) {
    if (map.rate_latency)
      add(fmt::format("{} {:.3f} ms with {:.6g} % of the segments late", map.name, ms(*map.rate_latency),
                      100 * *record.rate));
    if (map.adaptive)
      add(fmt::format("{} adaptive {:.3f} ms in the mean, {} forces late", map.name, ms(map.adaptive->mean),
                      map.adaptive->late));
  }
  return parts.empty() ? "" : "    " + parts + "\n";
}

}  // namespace

std::string what_if_text(const SizeRecord& record) {
  if (record.what_ifs.empty()) return "";
  std::size_t width = 0;
  for (const SizeWhatIf& one : record.what_ifs) width = std::max<std::size_t>(width, one.causal ? 14 : one.text.size());
  std::string out = "\n  What if\n" + heads(record, width);
  for (const SizeWhatIf& one : record.what_ifs) out += row(one, width) + (one.refused.empty() ? more(record, one) : "");
  return out +
         "  The bound is the pause bound. A row that looks back is what a simulator can do that does not know how long its "
         "next "
         "drawing\n  takes; all rows without one below them need not know ([timing] governor, docs/choose/pauses.md).\n";
}

}  // namespace evenstep::internal
