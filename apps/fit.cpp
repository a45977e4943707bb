#include <fmt/format.h>

#include "commands.h"
#include "evenstep/campaigns/fit_report.h"
#include "evenstep/recordings/timing_csv.h"

namespace evenstep::app {

ExitCode fit(const std::string& file, bool json) {
  const TimingCsv csv = read_timing_csv(file);
  if (!csv.errors.empty()) {
    print(csv.errors);
    return ExitCode::usage;
  }
  const std::string objection = fit_objection(csv.segments);
  if (!objection.empty()) {
    print({{file, 0, 0, objection}});
    return ExitCode::usage;
  }
  const TimingFit fitted = fit_timing(csv.segments);
  const FitComparison comparison = compare(fitted, csv.segments);
  fmt::print("{}", json ? fit_json(fitted, comparison, file) : fit_toml(fitted, comparison, file));
  return ExitCode::pass;
}

}  // namespace evenstep::app
