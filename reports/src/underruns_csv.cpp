#include <fmt/format.h>

#include <iterator>

#include "evenstep/reports/writers.h"
#include "src/text.h"

namespace evenstep {

std::string underruns_csv(const RunRecord& run) {
  std::string csv = "strategy,device,side,step,lateness_ns,policy\n";
  for (const StrategyRecord& strategy : run.strategies) {
    for (const UnderrunRow& row : strategy.underruns) {
      const char* side = row.side == UnderrunRow::Side::interaction ? "interaction" : "force";
      fmt::format_to(std::back_inserter(csv), "{},{},{},{},{},{}\n", internal::csv_field(strategy.name),
                     internal::csv_field(strategy.devices.at(row.device).name), side, row.step, row.lateness.ns,
                     internal::csv_field(row.policy));
    }
  }
  return csv;
}

}  // namespace evenstep
