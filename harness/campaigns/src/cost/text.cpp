#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "evenstep/campaigns/cost.h"

namespace evenstep {
namespace {

using Json = nlohmann::ordered_json;

std::string interval(const Measured& measured) { return fmt::format("[{:.3g}, {:.3g}]", measured.low, measured.high); }

std::string cost_of(const PartCost& part) {
  if (part.percent && part.percent->contains_0())
    return fmt::format("not measurable, % of {} {}", part.of, interval(*part.percent));
  if (part.percent) return fmt::format("{:.3g} % of {} {}", part.percent->median, part.of, interval(*part.percent));
  if (part.cpu_ms && part.resident_MiB) {
    return fmt::format("{:.3g} ms of CPU {} and {:.3g} MiB {} once", part.cpu_ms->median, interval(*part.cpu_ms),
                       part.resident_MiB->median, interval(*part.resident_MiB));
  }
  return "-";
}

const char* bits_of(PartCost::Bits bits) {
  constexpr const char* kWords[] = {"not compared", "equal", "differ"};
  return kWords[static_cast<std::size_t>(bits)];
}

Json json_of(const std::optional<Measured>& measured) {
  if (!measured) return nullptr;
  return {{"median", measured->median}, {"low", measured->low}, {"high", measured->high}};
}

}  // namespace

std::string cost_text(const CostReport& report) {
  std::string out = fmt::format(
      "  cost         measured here, in pairs with the part and without it; CPU time; median [95 % interval]\n"
      "               a step: {}\n               the run: {}\n",
      report.steps, report.run);
  const auto table = [&](bool is_kept) {
    for (const PartCost& part : report.parts) {
      if (part.is_kept != is_kept) continue;
      out += fmt::format("    {:<22} {}", part.part, cost_of(part));
      if (part.bits != PartCost::Bits::not_compared) out += fmt::format("; {} {}", part.compared, bits_of(part.bits));
      out += part.why.empty() ? "\n" : fmt::format("; {}\n", part.why);
    }
  };
  out += "  kept         its share of a step, or of the run; who asks for it\n";
  table(true);
  out += "  left out     what it would add\n";
  table(false);
  return out;
}

std::string cost_json(const CostReport& report) {
  Json parts = Json::array();
  for (const PartCost& part : report.parts) {
    parts.push_back({{"part", part.part},
                     {"kept", part.is_kept},
                     {"of", part.of},
                     {"percent", json_of(part.percent)},
                     {"measurable", part.percent ? Json(!part.percent->contains_0()) : Json(nullptr)},
                     {"cpu_ms", json_of(part.cpu_ms)},
                     {"resident_MiB", json_of(part.resident_MiB)},
                     {"bits", bits_of(part.bits)},
                     {"compared", part.compared},
                     {"why", part.why}});
  }
  return Json{{"steps", report.steps}, {"run", report.run}, {"same_bits", report.same_bits()}, {"parts", parts}}.dump();
}

}  // namespace evenstep
