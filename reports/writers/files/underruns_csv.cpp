#include "evenstep/reports/writers.h"
#include "writers/texts/text.h"

namespace evenstep {

void underruns_csv(const RunRecord& run, std::ostream& out) {
  out << "strategy,device,side,step,lateness_ns,policy\n";
  for (const StrategyRecord& strategy : run.strategies) {
    for (const UnderrunRow& row : strategy.underruns) {
      const char* side = row.side == UnderrunRow::Side::interaction ? "interaction" : "force";
      internal::print(out, "{},{},{},{},{},{}\n", internal::csv_field(strategy.name),
                      internal::csv_field(strategy.devices.at(row.device).name), side, row.step, row.lateness.ns,
                      internal::csv_field(std::string(row.policy)));
    }
  }
}

}  // namespace evenstep
