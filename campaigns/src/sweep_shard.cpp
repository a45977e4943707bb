#include <fmt/format.h>

#include <charconv>

#include "evenstep/campaigns/sweep.h"

namespace evenstep {
namespace {

constexpr int kMostShards = 1'000'000;

/// The environment variables of a batch system: the number of this shard, how many there are, and the number of the first.
/// More specific systems come first, because a task of an array also has the variables of tasks.
struct BatchSystem {
  const char* index;
  const char* count;
  const char* first;  ///< the variable with the number of the first shard, or nullptr
  int first_number;   ///< that number if there is no such variable
};
constexpr BatchSystem kBatchSystems[] = {
    {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", 0},
    {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", nullptr, 0},
    {"PMI_RANK", "PMI_SIZE", nullptr, 0},
    {"SLURM_PROCID", "SLURM_NTASKS", nullptr, 0},
    {"GTEST_SHARD_INDEX", "GTEST_TOTAL_SHARDS", nullptr, 0},
    {"CI_NODE_INDEX", "CI_NODE_TOTAL", nullptr, 1},
};

bool whole(std::string_view text, int& out) {
  const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc{} && at == text.data() + text.size();
}

bool is_shard(SweepShard shard) {
  return shard.of >= 1 && shard.of <= kMostShards && shard.index >= 1 && shard.index <= shard.of;
}

Result<SweepShard> shard_of_batch(const std::function<const char*(const char*)>& variable) {
  for (const BatchSystem& system : kBatchSystems) {
    const char *index = variable(system.index), *count = variable(system.count);
    if (index == nullptr || count == nullptr) continue;
    const char* first = system.first == nullptr ? nullptr : variable(system.first);
    SweepShard shard;
    int first_number = system.first_number;
    const bool fine =
        whole(index, shard.index) && whole(count, shard.of) && (first == nullptr || whole(first, first_number));
    shard.index += 1 - first_number;
    if (fine && is_shard(shard)) return shard;
    return Failure(fmt::format("{}={} and {}={} are no shard; write I/N instead", system.index, index, system.count, count));
  }
  return Failure(
      "auto: no batch system has set its variables (SLURM_ARRAY_TASK_ID, OMPI_COMM_WORLD_RANK, PMI_RANK, SLURM_PROCID, "
      "GTEST_SHARD_INDEX, CI_NODE_INDEX, each with its count); write I/N instead");
}

}  // namespace

Result<SweepShard> parse_shard(const std::string& text, const std::function<const char*(const char*)>& variable) {
  if (text == "auto") return shard_of_batch(variable);
  SweepShard shard;
  const std::size_t slash = text.find('/');
  const bool fine = slash != std::string::npos && whole(std::string_view(text).substr(0, slash), shard.index) &&
                    whole(std::string_view(text).substr(slash + 1), shard.of) && is_shard(shard);
  if (!fine) return Failure(fmt::format("\"{}\" must be I/N with I from 1 to N, such as 2/5, or auto", text));
  return shard;
}

}  // namespace evenstep
