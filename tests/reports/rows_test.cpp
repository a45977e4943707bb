#include "evenstep/reports/rows.h"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "cases.h"
#include "catch.h"
#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/reports/writers.h"
#include "synthetic.h"
#include "temporary_folder.h"

using namespace evenstep;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

/// The same record with its rows in files.
RunRecord in_files(const RunRecord& run, const std::shared_ptr<RowFiles>& files) {
  RunRecord copy = run;
  for (StrategyRecord& strategy : copy.strategies) {
    strategy.steps = Rows<StepRow>(strategy.steps.begin(), strategy.steps.end(), files);
    for (DeviceRecord& device : strategy.devices) {
      device.steps = Rows<StepSample>(device.steps.begin(), device.steps.end(), files);
      device.ticks = Rows<TickRow>(device.ticks.begin(), device.ticks.end(), files);
    }
  }
  return copy;
}

}  // namespace

TEST_CASE("rows in files read as rows in memory do: the same summary, the same series, for a minute of four strategies") {
  const TemporaryFolder folder;
  // With sanitizers ten seconds, of which only the ticks are so many that they go into a file.
  const RunRecord run = synthetic::reference_run({(testing::kSanitized ? 10 : 60) * 1'000'000'000LL});
  const RunRecord filed = in_files(run, std::make_shared<RowFiles>(folder.path()));
  const auto summary = [](const RunRecord& record) {
    Metrics metrics = measure(record);
    add_growths(record, metrics);
    return summary_json(record, metrics, {}, "1", "pass");
  };
  CHECK(summary(filed) == summary(run));
  CHECK(synthetic::written(series_csv, filed) == synthetic::written(series_csv, run));
}

TEST_CASE("256 MiB of rows in a file, written and read again, take less than 96 MiB of memory, and no name in the folder",
          "[sweep]") {
  const TemporaryFolder folder;
  Rows<std::uint64_t> rows(std::make_shared<RowFiles>(folder.path()));
  constexpr std::uint64_t kCount = (256 << 20) / sizeof(std::uint64_t);
  const std::size_t before = resident_bytes();
  std::size_t most = 0;
  const auto look = [&](std::uint64_t i) {
    if (i % (1 << 20) == 0) most = std::max(most, std::max(resident_bytes(), before) - before);
  };
  for (std::uint64_t i = 0; i < kCount; ++i, look(i)) rows.push_back(i * i);
  std::uint64_t wrong = 0;
  for (std::uint64_t i = 0; i < kCount; ++i, look(i)) wrong += rows[i] != i * i;
  CHECK(wrong == 0);
  CHECK(most < 96 << 20);  // 32 MiB and what is touched on a busy machine between two looks of the thread
  CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("a folder without room for the rows, or none at all, fails the run with a remedy") {
  const TemporaryFolder folder;
  const auto reason = [](const fs::path& place) -> std::string {
    try {
      Rows<char>(64 << 20, 'x', std::make_shared<RowFiles>(place));
    } catch (const RunFailure& failure) {
      return failure.reason + (failure.remedy.empty() ? " without remedy" : "");
    }
    return "none";
  };
  CHECK(reason(folder.path() / "absent") == "disk");
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1 << 20, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ::setrlimit(RLIMIT_FSIZE, &small);
  const std::string full = reason(folder.path());
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  CHECK(full == "disk");
  CHECK(reason(folder.path()) == "none");
}
