#include <fmt/format.h>

#include <charconv>
#include <vector>

#include "evenstep/campaigns/parts.h"

namespace evenstep {
namespace {

/// The environment variables with the number of a process, and how many there are.
struct BatchSystem {
  const char* number;
  const char* count;  ///< nullptr: none to be trusted, because some of many jobs may have been submitted again alone
  int first;          ///< the number of the first shard
};
constexpr BatchSystem kBatchSystems[] = {
    {"SLURM_ARRAY_TASK_ID", nullptr, 1},   // its _COUNT is that of the submission: 2 for --array=3,17
    {"JOB_COMPLETION_INDEX", nullptr, 0},  // an indexed job of Kubernetes
    {"PARALLEL_SEQ", nullptr, 1},          // GNU parallel
    {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", 0},
    {"PMI_RANK", "PMI_SIZE", 0},
    {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS", 0},  // not SLURM_NTASKS: a batch script, which runs once, has that too
    {"GTEST_SHARD_INDEX", "GTEST_TOTAL_SHARDS", 0},
    {"CI_NODE_INDEX", "CI_NODE_TOTAL", 1},
};

using Variable = std::function<const char*(const char*)>;

bool whole(std::string_view text, int& out) {
  const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc{} && at == text.data() + text.size();
}

bool is_shard(Shard shard) {
  return shard.of >= 1 && shard.of <= kMostShards && shard.index >= 1 && shard.index <= shard.of;
}

/// What one system says. Nothing if it has not set its variables.
Result<std::optional<ShardSaid>> shard_of(const BatchSystem& system, std::optional<int> of, const Variable& variable) {
  const char* number = variable(system.number);
  const char* count = system.count == nullptr ? nullptr : variable(system.count);
  if (number == nullptr || (system.count != nullptr && count == nullptr)) return std::optional<ShardSaid>{};
  ShardSaid said{{0, of.value_or(0)}, fmt::format("{}={}", system.number, number)};
  if (count != nullptr)
    said.by += fmt::format(" {}={}", system.count, count);
  else if (!of)
    return Failure(said.by + " is not of a known number of shards, because jobs can be submitted again alone: add --of N");
  const bool numbers = whole(number, said.shard.index) && (count == nullptr || whole(count, said.shard.of));
  if (of) said.by += fmt::format(" --of {}", *of);
  if (numbers && said.shard.index >= system.first && said.shard.index <= kMostShards) {
    said.shard.index += 1 - system.first;
    const bool agrees = count == nullptr || !of || said.shard.of == *of || said.shard.of == 1;
    if (is_shard(said.shard) && !agrees)
      return Failure(fmt::format("{}: these are {} shards or {}; leave out --of, or start as many processes", said.by,
                                 said.shard.of, *of));
    if (is_shard(said.shard)) return std::optional(said);
  }
  const bool counted = count != nullptr ? whole(count, said.shard.of) : of.has_value();
  const std::string known = counted && said.shard.of >= 1
                                ? fmt::format("are {} to {}", system.first, said.shard.of - 1 + system.first)
                                : fmt::format("begin with {}", system.first);
  return Failure(fmt::format("{} is no shard: their numbers {}; correct it, or write I/N instead", said.by, known));
}

/// Says why the tasks of a Slurm array cannot be shards of so many, or nothing.
std::string wrong_array(int of, const Variable& variable) {
  int id = 0, min = 0, max = 0, count = 0;
  const auto read = [&](const char* name, int& out) {
    const char* text = variable(name);
    return text != nullptr && whole(text, out);
  };
  if (!read("SLURM_ARRAY_TASK_ID", id) || !read("SLURM_ARRAY_TASK_MIN", min) || !read("SLURM_ARRAY_TASK_MAX", max) ||
      !read("SLURM_ARRAY_TASK_COUNT", count))
    return {};
  if (1 <= min && min <= id && id <= max && max <= of && 1 <= count && count <= max - min + 1) return {};
  return fmt::format(
      "SLURM_ARRAY_TASK_ID={} of {} tasks from {} to {} contradicts --of {}: the tasks must be numbers of "
      "shards, --array=1-{} or some of these",
      id, count, min, max, of, of);
}

/// What each system says that has set its variables.
Result<std::vector<ShardSaid>> all_said(std::optional<int> of, const Variable& variable) {
  std::vector<ShardSaid> all;
  std::optional<ShardSaid> single;  // one process is a part of nothing, such as the only task of an array's job
  bool mpi = false;
  for (const BatchSystem& system : kBatchSystems) {
    // The tasks of a Slurm step may be the daemons of an MPI, and have the ranks below them.
    if (mpi && system.number == std::string_view("SLURM_PROCID")) continue;
    const Result<std::optional<ShardSaid>> said = shard_of(system, of, variable);
    if (!said) return Failure(said.error());
    if (!*said) continue;
    if (system.count != nullptr && (*said)->shard.of == 1) {
      single = **said;
      continue;
    }
    mpi = mpi || std::string_view(system.number).ends_with("_RANK");
    all.push_back(**said);
  }
  if (all.empty() && single && of.value_or(1) == 1) all.push_back(*single);
  return all;
}

Result<ShardSaid> shard_of_batch(std::optional<int> of, const Variable& variable) {
  const Result<std::vector<ShardSaid>> all = all_said(of, variable);
  if (!all) return Failure(all.error());
  if (all->empty()) {
    std::string names, halves;
    for (const BatchSystem& system : kBatchSystems) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", system.number);
      if (system.count != nullptr && variable(system.number) != nullptr && variable(system.count) == nullptr)
        halves += fmt::format("; {} is set, and {} is not", system.number, system.count);
    }
    return Failure(
        fmt::format("auto: no batch system says which of several shards this is ({}){}; write I/N instead", names, halves));
  }
  for (const ShardSaid& other : *all) {
    if (other.shard.index != all->front().shard.index || other.shard.of != all->front().shard.of)
      return Failure(fmt::format("{} and {} contradict each other; write I/N instead", all->front().by, other.by));
  }
  if (of) {
    if (const std::string wrong = wrong_array(*of, variable); !wrong.empty()) return Failure(wrong);
  }
  return all->front();
}

}  // namespace

Result<ShardSaid> parse_shard(const std::string& text, std::optional<int> of, const Variable& variable) {
  if (text == "auto") return shard_of_batch(of, variable);
  if (of) return Failure(fmt::format("\"{}\" and --of {}: --of belongs to --shard auto", text, *of));
  Shard shard;
  const std::size_t slash = text.find('/');
  const bool fine = slash != std::string::npos && whole(std::string_view(text).substr(0, slash), shard.index) &&
                    whole(std::string_view(text).substr(slash + 1), shard.of) && is_shard(shard);
  if (!fine) return Failure(fmt::format("\"{}\" must be I/N with I from 1 to N, such as 2/5, or auto", text));
  return ShardSaid{shard, {}};
}

}  // namespace evenstep
