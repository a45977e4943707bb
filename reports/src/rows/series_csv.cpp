#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "evenstep/reports/writers.h"
#include "src/judged.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

constexpr const char* kHeader =
    "t[s],strategy,device,kind,index,simulation_time[s],read[s],emission[s],end[s],x[m],y[m],z[m],fx[N],fy[N],fz[N],state,"
    "lateness[s],"
    "deviation_max[m],velocity_jump[m],underruns,force_deviation_max[N],force_velocity_jump[N],late\n";

const char* name_of(StepRead read) {
  switch (read) {
    case StepRead::inside:
      return "inside";
    case StepRead::underrun:
      return "underrun";
    case StepRead::overrun:
      return "overrun";
    case StepRead::newest:
      return "newest";
    case StepRead::acquiring:
      return "acquiring";
    case StepRead::gated:
      return "gated";
    case StepRead::predicted:
      return "predicted";
  }
  return "unknown";
}

void put_steps(std::ostream& out, const StrategyRecord& strategy, const DeviceRecord& device, const std::string& who,
               double slot_s) {
  for (std::size_t n = 0; n < std::min(strategy.steps.size(), device.steps.size()); ++n) {
    const StepRow& step = strategy.steps[n];
    const StepSample& sample = device.steps[n];
    internal::print(out, "{},{},step,{},{},{},{},{},{},{},{},{},{},{},{},,,,,,,\n", internal::exact_seconds(step.begin), who,
                    n, internal::simulation_time_s(strategy, n, slot_s), internal::exact_seconds(step.read),
                    internal::exact_seconds(step.emission), internal::exact_seconds(step.end), sample.position_m[0],
                    sample.position_m[1], sample.position_m[2], sample.force_N[0], sample.force_N[1], sample.force_N[2],
                    name_of(sample.read));
  }
}

void put_ticks(std::ostream& out, const DeviceRecord& device, const std::string& who) {
  for (std::size_t k = 0; k < device.ticks.size(); ++k) {
    const TickRow& tick = device.ticks[k];
    internal::print(out, "{},{},tick,{},,,,,{},{},{},{},{},{},{},{},,,,,,\n", internal::exact_seconds(tick.at), who, k,
                    tick.position_m[0], tick.position_m[1], tick.position_m[2], tick.force_N[0], tick.force_N[1],
                    tick.force_N[2], tick.started ? "started" : "waiting", internal::exact_seconds({tick.lateness.ns}));
  }
}

void put_bins(std::ostream& out, const std::vector<BinRow>& rows, const std::string& who, bool interaction) {
  for (std::size_t b = 0; b < rows.size(); ++b) {
    const std::string values =
        fmt::format("{},{},{}", rows[b].deviation_max, rows[b].velocity_jump, rows[b].underruns_so_far);
    internal::print(out, "{},{},{},{},,,,,,,,,,,,,{}\n", rows[b].from_s, who, interaction ? "interaction_bin" : "force_bin",
                    b, interaction ? values + ",,," : ",,," + values);
  }
}

}  // namespace

void series_csv(const RunRecord& run, std::ostream& out) {
  const auto all_bins = bins(run);
  out << kHeader;
  for (const StrategyRecord& strategy : run.strategies) {
    for (const DeviceRecord& device : strategy.devices) {
      const std::string who = internal::csv_field(strategy.name) + ',' + internal::csv_field(device.name);
      if (run.keep_rows) {
        put_steps(out, strategy, device, who, run.nominal.slot_s);
        put_ticks(out, device, who);
      }
      put_bins(out, all_bins.at(device.name + ".interaction." + strategy.name), who, true);
      put_bins(out, all_bins.at(device.name + ".force." + strategy.name), who, false);
    }
  }
}

}  // namespace evenstep
