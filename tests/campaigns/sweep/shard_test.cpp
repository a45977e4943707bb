// Which shard this process is: as the command line says, or as the variables of a batch system say. The values used here are
// those that Slurm 22.05, Open MPI 4.1 and GNU parallel 20221122 set.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "catch.h"
#include "evenstep/campaigns/sweep.h"

using namespace evenstep;
using Catch::Contains;

namespace {

using Variables = std::vector<std::pair<std::string, std::string>>;

Result<ShardSaid> shard(const Variables& variables, std::optional<int> of = {}, const std::string& text = "auto") {
  return parse_shard(text, of, [&](const char* name) -> const char* {
    for (const auto& [key, value] : variables) {
      if (key == name) return value.c_str();
    }
    return nullptr;
  });
}

/// A task of an array as Slurm 22.05 describes it, inside a batch script of one task.
Variables array(int id, int count, int min, int max, int step = 1) {
  return {{"SLURM_ARRAY_TASK_ID", std::to_string(id)},     {"SLURM_ARRAY_TASK_COUNT", std::to_string(count)},
          {"SLURM_ARRAY_TASK_MIN", std::to_string(min)},   {"SLURM_ARRAY_TASK_MAX", std::to_string(max)},
          {"SLURM_ARRAY_TASK_STEP", std::to_string(step)}, {"SLURM_PROCID", "0"}};
}

Variables both(Variables a, const Variables& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

bool is(const Result<ShardSaid>& said, int index, int of) {
  return said.ok() && said->shard.index == index && said->shard.of == of;
}

}  // namespace

TEST_CASE("A shard is written as I of N") {
  CHECK(is(shard({}, {}, "2/5"), 2, 5));
  CHECK(is(shard({}, {}, "1/1"), 1, 1));
  for (const char* bad : {"", "0/5", "6/5", "2", "2/", "/5", "a/b", "2/5x", "-1/5", "2/0", "1/1000001"}) {
    INFO(bad);
    CHECK_FALSE(shard({}, {}, bad).ok());
  }
  CHECK_THAT(shard({}, 5, "2/5").error(), Contains("--of belongs to --shard auto"));
  CHECK_THAT(shard({{"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "4"}}, 40).error(),
             Contains("these are 4 shards or 40"));
  CHECK_THAT(shard({}).error(), Contains("SLURM_ARRAY_TASK_ID") && Contains("JOB_COMPLETION_INDEX"));
}

TEST_CASE("A task of a Slurm array is the shard of its number whichever tasks were submitted") {
  for (int id = 1; id <= 40; ++id) CHECK(is(shard(array(id, 40, 1, 40), 40), id, 40));
  CHECK(is(shard(array(3, 2, 3, 17), 40), 3, 40));  // --array=3,17
  CHECK(is(shard(array(17, 2, 3, 17), 40), 17, 40));
  CHECK(is(shard(array(5, 1, 5, 5), 40), 5, 40));       // --array=5
  CHECK(is(shard(array(7, 14, 1, 40, 3), 40), 7, 40));  // --array=1-40:3
  CHECK_THAT(shard(array(3, 2, 3, 17), 40)->by, Contains("SLURM_ARRAY_TASK_ID=3 --of 40"));
}

TEST_CASE("A numbered job without the number of shards is refused, since it may have been submitted again alone") {
  for (const Variables& variables :
       {array(3, 2, 3, 17), array(1, 40, 1, 40), Variables{{"JOB_COMPLETION_INDEX", "0"}}, Variables{{"PARALLEL_SEQ", "1"}}})
    CHECK_THAT(shard(variables).error(), Contains("--of N"));
}

TEST_CASE("An array that cannot be of so many shards is refused") {
  CHECK_FALSE(shard(array(0, 40, 0, 39), 40).ok());  // --array=0-39: would its task 3 be shard 3 or 4?
  CHECK_THAT(shard(array(3, 40, 0, 39), 40).error(), Contains("--array=1-40"));
  CHECK_THAT(shard(array(3, 41, 1, 41), 40).error(), Contains("contradicts --of 40"));
  CHECK_FALSE(shard(array(41, 41, 1, 41), 40).ok());
  CHECK_FALSE(shard(array(2, 2, 3, 17), 40).ok());  // a number outside the array
  CHECK_FALSE(shard(array(18, 2, 3, 17), 40).ok());
  CHECK_FALSE(shard(array(3, 16, 3, 17), 40).ok());  // more tasks than numbers
  CHECK_FALSE(shard({{"SLURM_ARRAY_TASK_ID", "x"}}, 40).ok());
}

TEST_CASE("An indexed job of Kubernetes counts from 0 and GNU parallel from 1") {
  CHECK(is(shard({{"JOB_COMPLETION_INDEX", "0"}}, 40), 1, 40));
  CHECK(is(shard({{"JOB_COMPLETION_INDEX", "39"}}, 40), 40, 40));
  CHECK_FALSE(shard({{"JOB_COMPLETION_INDEX", "40"}}, 40).ok());
  CHECK(is(shard({{"PARALLEL_SEQ", "1"}}, 40), 1, 40));
  CHECK_FALSE(shard({{"PARALLEL_SEQ", "0"}}, 40).ok());
  CHECK_FALSE(shard({{"PARALLEL_SEQ", "41"}}, 40).ok());
  CHECK_FALSE(shard({{"PARALLEL_SEQ", "99999999999"}}, 40).ok());
}

TEST_CASE("Processes that are started together know how many they are and --of must agree") {
  const Variables mpi = {{"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "2"}};
  CHECK(is(shard(mpi), 2, 2));
  CHECK(is(shard(mpi, 2), 2, 2));
  CHECK_FALSE(shard(mpi, 40).ok());
  CHECK(is(shard({{"PMI_RANK", "0"}, {"PMI_SIZE", "2"}}), 1, 2));
  CHECK(is(shard({{"SLURM_PROCID", "3"}, {"SLURM_STEP_NUM_TASKS", "4"}}), 4, 4));
  CHECK(is(shard({{"CI_NODE_INDEX", "2"}, {"CI_NODE_TOTAL", "2"}}), 2, 2));
  CHECK_FALSE(shard({{"CI_NODE_INDEX", "3"}, {"CI_NODE_TOTAL", "2"}}).ok());
  CHECK_FALSE(shard({{"CI_NODE_INDEX", "0"}, {"CI_NODE_TOTAL", "2"}}).ok());
  CHECK_FALSE(shard({{"OMPI_COMM_WORLD_RANK", "-1"}, {"OMPI_COMM_WORLD_SIZE", "2"}}).ok());
}

TEST_CASE("What is no shard says which numbers are, and which variable lacks its other half") {
  CHECK_THAT(shard({{"SLURM_ARRAY_TASK_ID", "17"}}, 10).error(), Contains("numbers are 1 to 10"));
  CHECK_THAT(shard({{"JOB_COMPLETION_INDEX", "10"}}, 10).error(), Contains("numbers are 0 to 9"));
  CHECK_THAT(shard({{"OMPI_COMM_WORLD_RANK", "4"}, {"OMPI_COMM_WORLD_SIZE", "4"}}).error(), Contains("numbers are 0 to 3"));
  CHECK_THAT(shard({{"OMPI_COMM_WORLD_RANK", "0"}, {"OMPI_COMM_WORLD_SIZE", "x"}}).error(), Contains("begin with 0"));
  CHECK_THAT(shard({{"OMPI_COMM_WORLD_RANK", "3"}}, 10).error(),
             Contains("OMPI_COMM_WORLD_RANK is set, and OMPI_COMM_WORLD_SIZE is not"));
  CHECK_THAT(shard({}, 10).error(), !Contains("is set"));
}

TEST_CASE("A batch script that runs once is no shard of the tasks it may start") {
  CHECK_FALSE(shard({{"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}}).ok());
}

TEST_CASE("Systems that contradict each other are refused and a single process contradicts nothing") {
  const Variables task = array(3, 40, 1, 40);
  const Variables ranks = {{"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "40"}};
  CHECK_THAT(shard(both(task, ranks), 40).error(), Contains("SLURM_ARRAY_TASK_ID=3") && Contains("OMPI_COMM_WORLD_RANK=1"));
  CHECK_FALSE(shard(both(task, {{"PARALLEL_SEQ", "4"}}), 40).ok());
  CHECK(is(shard(both(task, {{"SLURM_STEP_NUM_TASKS", "1"}}), 40), 3, 40));
  CHECK(is(shard(both(task, {{"CI_NODE_INDEX", "1"}, {"CI_NODE_TOTAL", "1"}}), 40), 3, 40));
  CHECK_FALSE(shard(both(ranks, {{"PMI_RANK", "2"}, {"PMI_SIZE", "40"}})).ok());
  CHECK(is(shard(both(ranks, {{"PMI_RANK", "1"}, {"PMI_SIZE", "40"}})), 2, 40));
  const Variables alone = {{"OMPI_COMM_WORLD_RANK", "0"}, {"OMPI_COMM_WORLD_SIZE", "1"}};
  CHECK(is(shard(alone), 1, 1));
  CHECK_FALSE(shard(alone, 40).ok());
}

TEST_CASE("The ranks of an MPI count where its daemons are tasks of a Slurm step") {
  CHECK(is(shard({{"SLURM_PROCID", "1"},
                  {"SLURM_STEP_NUM_TASKS", "2"},
                  {"OMPI_COMM_WORLD_RANK", "5"},
                  {"OMPI_COMM_WORLD_SIZE", "8"}}),
           6, 8));
}
