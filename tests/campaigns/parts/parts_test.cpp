// Studies, sizings and the catalogue in shards. Apart from what is measured, the result is the same in any number of shards,
// in any order, also after a shard was killed.
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <thread>

#include "cases.h"
#include "catch.h"
#include "evenstep/campaigns/catalogue_parts.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/campaigns/study.h"
#include "evenstep/campaigns/study_parts.h"
#include "files.h"
#include "src/shards/json_parts.h"

using namespace evenstep;
using Catch::Contains;
using test::contents;
using testing::TemporaryFolder;

namespace {

const std::string kScenarios = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/";

/// A kind of work. `run` does the part that its options name.
struct Kind {
  std::string name;
  std::int64_t items;
  std::function<PartOutcome(const PartOptions&)> run;
};

PartOutcome study(const std::string& file, const std::vector<std::string>& set, const PartOptions& part) {
  const ReadResult scenario = read_scenario(kScenarios + file, {set, std::nullopt});
  for (const Diagnostic& error : scenario.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(scenario);
  StudyPartsOptions options;
  static_cast<PartOptions&>(options) = part;
  options.set = set;
  return run_study_parts(*scenario, kScenarios + file, options);
}

const std::vector<std::string> kState{"scene.lattice=[5, 5, 5]",
                                      "device.left.grab.center=[\"10 mm\", \"10 mm\", \"20 mm\"]",
                                      "device.left.grab.radius=\"5.5 mm\"",
                                      "study.duration=\"16 ms\"",
                                      "study.repeats=1",
                                      "study.solvers=[\"cpu-double\"]",
                                      "study.methods=[\"symplectic-euler\", \"velocity-verlet\"]",
                                      "study.step_sizes=[\"1 ms\", \"0.5 ms\", \"0.25 ms\"]"};

CatalogueOptions catalogue_options(const PartOptions& part) {
  CatalogueOptions options;
  static_cast<PartOptions&>(options) = part;
  options.files = {kScenarios + "stiff/s2-over-the-limit.toml", kScenarios + "extreme/s16-degenerate.toml",
                   kScenarios + "extreme/unstable-step.toml"};
  return options;
}

SizeSeedsOptions size_options(const PartOptions& part) {
  SizeSeedsOptions options;
  static_cast<PartOptions&>(options) = part;
  options.first_seed = 3;
  options.seeds = 15;
  options.rate = 0.02;
  return options;
}

std::vector<Kind> kinds(const std::string& sized) {
  return {{"study", 7, [](const PartOptions& part) { return study("stiff/study-block.toml", kState, part); }},
          {"size", 15, [sized](const PartOptions& part) { return size_seeds(sized, size_options(part)); }},
          {"catalogue", 0,
           [](const PartOptions& part) { return run_catalogue(catalogue_options(part), [](CatalogueEntry&) {}); }}};
}

/// How many of these kinds are tried. With sanitizers the runs of the catalogue would take a minute, and its parts are
/// written and read like the others.
constexpr std::size_t kKinds = testing::kSanitized ? 2 : 3;

PartOptions options(const std::string& folder, Shard shard = {}, bool resume = false) {
  PartOptions out;
  out.folder = folder;
  out.shard = shard;
  out.resume = resume;
  out.threads = 2;
  return out;
}

/// The lines without what was measured, and therefore without their checksums.
std::vector<std::string> certain(const std::string& file) {
  std::vector<std::string> lines;
  std::istringstream text(contents(file));
  for (std::string line; std::getline(text, line);) {
    Json json = Json::parse(line);
    json.erase("measured");
    json.erase("check");
    lines.push_back(json_text(json));
  }
  return lines;
}

std::vector<std::string> shards(const Kind& kind, const TemporaryFolder& folder, int of) {
  std::vector<std::string> parts;
  for (int i = 1; i <= of; ++i) {
    const PartOutcome outcome = kind.run(options(folder / fmt::format("of-{}", of), {i, of}));
    INFO(outcome.failure);
    REQUIRE(outcome.failure.empty());
    REQUIRE(outcome.errors.empty());
    REQUIRE(outcome.exit == ExitCode::pass);
    parts.push_back(outcome.file);
  }
  return parts;
}

/// The same value, or both not a number, as where a cell has diverged.
bool same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

std::size_t lines_in(const std::string& file) {
  std::ifstream in(file);
  std::size_t count = 0;
  for (std::string line; std::getline(in, line);) ++count;
  return count;
}

}  // namespace

TEST_CASE("Studies and sizings and the catalogue are the same in two and seven shards in any order", "[sweep]") {
  const TemporaryFolder folder;
  const std::string sized = folder.write("sized.toml", test::small_scenario(""));
  const Kind kind = kinds(sized)[GENERATE(range(std::size_t{0}, kKinds))];
  INFO(kind.name);
  const PartOutcome one = kind.run(options(folder / "one", {}));
  INFO(one.failure);
  REQUIRE(one.failure.empty());
  REQUIRE(one.errors.empty());
  CHECK(one.exit == ExitCode::pass);
  CHECK(one.done == one.items);
  if (kind.items > 0) CHECK(one.items == kind.items);
  CHECK(one.items >= 7);
  const std::vector<std::string> lines = certain(one.file);
  CHECK(std::ssize(lines) == one.items + 1);
  for (const int of : {2, 7}) {
    std::vector<std::string> parts = shards(kind, folder, of);
    for (int turn = 0; turn < 3; ++turn) {
      std::rotate(parts.begin(), parts.begin() + 1, parts.end());
      if (turn == 2) std::reverse(parts.begin(), parts.end());
      const std::string out = folder / fmt::format("merged-{}-{}/{}.jsonl", of, turn, kind.name);
      const PartOutcome merged = merge_parts(parts, out);
      REQUIRE(merged.errors.empty());
      REQUIRE(merged.failure.empty());
      CHECK(certain(out) == lines);
      if (turn > 0) CHECK(contents(out) == contents(folder / fmt::format("merged-{}-0/{}.jsonl", of, kind.name)));
      if (kind.name != "study") CHECK(contents(out) == contents(one.file));  // nothing in it is measured
      CHECK(kind_of_part(out) == kind.name);
    }
    // A process that finds the merged lines only reads them.
    const std::string bytes = contents(folder / fmt::format("merged-{}-0/{}.jsonl", of, kind.name));
    const PartOutcome read = kind.run(options(folder / fmt::format("merged-{}-0", of), {}, true));
    CHECK(read.exit == one.exit);
    CHECK(read.done == one.items);
    CHECK(contents(read.file) == bytes);
  }
}

TEST_CASE("Gaps and duplicates and other kinds and damaged lines of any work are refused") {
  const TemporaryFolder folder;
  const std::string sized = folder.write("sized.toml", test::small_scenario(""));
  const std::vector<Kind> all = kinds(sized);
  const Kind& kind = all[GENERATE(range(std::size_t{0}, kKinds))];
  INFO(kind.name);
  const std::vector<std::string> parts = shards(kind, folder, 3);
  const std::string out = folder / "merged.jsonl";
  const auto refusal = [&](const std::vector<std::string>& some) {
    const PartOutcome merged = merge_parts(some, out);
    CHECK(merged.exit == ExitCode::usage);
    CHECK_FALSE(std::filesystem::exists(out));
    REQUIRE(merged.errors.size() == 1);
    return text(merged.errors.front());
  };
  CHECK_THAT(refusal({parts[2], parts[0]}), Contains("shard 2 of 3 is missing"));
  CHECK_THAT(refusal({parts[0]}), Contains("shards 2, 3 of 3 are missing"));
  CHECK_THAT(refusal({parts[0], parts[1], parts[2], parts[1]}), Contains("merge each part once"));
  std::string text = contents(parts[1]);
  const std::string good = text;
  text[text.size() / 2] ^= 1;
  CHECK_THAT(refusal({parts[0], folder.write("bent", text), parts[2]}), Contains("checksum") || Contains("no end"));
  CHECK_THAT(refusal({parts[0], folder.write("torn", good.substr(0, good.size() - 1)), parts[2]}), Contains("has no end"));
  std::string other = good;  // another build, with the right checksum
  const std::size_t end = other.find('\n');
  Json header = Json::parse(other.substr(0, end));
  header.erase("check");
  header["build"] = "0.0.0-0123456789abcdef";
  other = internal::with_checksum(json_text(header)) + other.substr(end);
  CHECK_THAT(refusal({parts[0], folder.write("build", other), parts[2]}), Contains("is of another build of evenstep"));
  const Kind& foreign = all[kind.name == "size" ? 0 : 1];
  const std::string foreign_part = foreign.run(options(folder / "foreign", {1, 3})).file;
  CHECK_THAT(refusal({parts[0], parts[1], parts[2], foreign_part}),
             Contains(fmt::format("is of a {}, but ", foreign.name)) && Contains(fmt::format(" of a {}", kind.name)));
}

TEST_CASE("A shard of any work that was killed and goes on loses no line and gives the same bytes", "[sweep]") {
  const TemporaryFolder folder;
  const std::string sized = folder.write("sized.toml", test::small_scenario(""));
  const Kind kind = kinds(sized)[GENERATE(range(std::size_t{0}, kKinds))];
  INFO(kind.name);
  const std::vector<std::string> parts = shards(kind, folder, 2);
  const std::string file = folder / fmt::format("killed/{}-1-of-2.jsonl", kind.name), partial = file + ".partial";
  for (const std::size_t least : {2U, 3U}) {  // how many lines are there when the process is killed
    std::filesystem::remove_all(folder / "killed");
    const pid_t child = ::fork();
    if (child == 0) {
      kind.run(options(folder / "killed", {1, 2}));
      ::_exit(0);
    }
    while (lines_in(partial) < least && ::waitpid(child, nullptr, WNOHANG) == 0)  // or the process has ended
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const std::string kept = std::filesystem::exists(partial) ? contents(partial) : contents(file);
    const std::string whole_lines = kept.substr(0, kept.rfind('\n') + 1);
    const PartOutcome rest = kind.run(options(folder / "killed", {1, 2}, true));
    REQUIRE(rest.failure.empty());
    CHECK(contents(file).substr(0, whole_lines.size()) == whole_lines);
    const std::string out = folder / "merged.jsonl", undisturbed = folder / "undisturbed.jsonl";
    REQUIRE(merge_parts({parts[1], file}, out).errors.empty());
    REQUIRE(merge_parts(parts, undisturbed).errors.empty());
    CHECK(certain(out) == certain(undisturbed));
  }
}

TEST_CASE("A study in parts has the errors of a study in one piece and says which machines measured") {
  const TemporaryFolder folder;
  const std::string path = kScenarios + "stiff/study-block.toml";
  const ReadResult scenario = read_scenario(path, {kState, std::nullopt});
  REQUIRE(scenario);
  StudyPartsOptions part;
  static_cast<PartOptions&>(part) = options(folder / "parts");
  part.set = kState;
  const StudyPartsOutcome outcome = run_study_parts(*scenario, path, part);
  REQUIRE(std::holds_alternative<StudyRecord>(outcome.record));
  const auto& merged = std::get<StudyRecord>(outcome.record);
  const StudyRecord whole = run_study(*scenario);
  REQUIRE(merged.cells.size() == whole.cells.size());
  for (std::size_t i = 0; i < whole.cells.size(); ++i) {
    for (const StudyQuantity q : kStudyQuantities) {
      CHECK(same_number(merged.cells[i].error[q], whole.cells[i].error[q]));
      CHECK(same_number(merged.cells[i].order[q], whole.cells[i].order[q]));
    }
    CHECK(merged.cells[i].state == whole.cells[i].state);
    CHECK((merged.cells[i].cpu.median > 0) == (whole.cells[i].cpu.median > 0));
    CHECK(merged.cells[i].machine.empty());
  }
  CHECK(merged.reference.estimate[StudyQuantity::force] == whole.reference.estimate[StudyQuantity::force]);
  CHECK(merged.machine == whole.machine);

  // The same lines, but one of them was measured on another machine.
  std::istringstream lines(contents(outcome.file));
  std::string changed;
  for (std::string line; std::getline(lines, line);) {
    Json json = Json::parse(line);
    json.erase("check");
    if (json.contains("cell") && json["index"] == 2) json["measured"]["machine"] = "another";
    if (json.contains("cell") && json["cell"]["state"] == "refused") json["measured"]["machine"] = "a third";  // no costs
    changed += internal::with_checksum(json_text(json)) + '\n';
  }
  folder.write("parts/study.jsonl", changed);
  part.resume = true;
  const auto mixed = std::get<StudyRecord>(run_study_parts(*scenario, path, part).record);
  CHECK_THAT(mixed.machine, Contains("2 machines: ") && Contains("another, "));
  CHECK(mixed.cpus == 0);
  CHECK_THAT(mixed.cells[1].machine, Contains("another"));
  CHECK_THAT(study_json(mixed), Contains("\"machine\":\"another"));
  REQUIRE(mixed.machines.size() == 2);
  CHECK_THAT(advise(mixed, *parse_goal("50 % force")).text, Contains("\nwarning: the costs were measured on 2 machines") &&
                                                                Contains("#1 " + mixed.machines[0]) &&
                                                                Contains("#2 " + mixed.machines[1]));
  CHECK(merged.machines.empty());
}

TEST_CASE("A catalogue in parts is judged as its scenarios are when they are run", "[sweep]") {
  const TemporaryFolder folder;
  CatalogueOptions part = catalogue_options(options(folder / "parts"));
  int count = 0;
  const CatalogueOutcome outcome = run_catalogue(part, [&](CatalogueEntry& entry) {
    const RunOutcome run = run_scenario(*entry.scenario, {});
    CHECK(entry.outcome.exit == run.exit);
    CHECK(entry.outcome.record.trace_hash == run.record.trace_hash);
    REQUIRE(entry.outcome.case_record.has_value() == run.case_record.has_value());
    if (run.case_record) {
      CHECK(cells_csv(*entry.outcome.case_record) == cells_csv(*run.case_record));
      CHECK(entry.outcome.results.size() == run.results.size());
    }
    ++count;
  });
  CHECK(count == 3);
  CHECK(outcome.exit == ExitCode::pass);
  // A wrong cell makes the whole fail, although every line is undamaged.
  std::istringstream lines(contents(outcome.file));
  std::string changed;
  for (std::string line; std::getline(lines, line);) {
    Json json = Json::parse(line);
    json.erase("check");
    if (json.contains("cell") && json["index"] == 20) json["cell"]["schedule_differs"] = true;  // rk4
    changed += internal::with_checksum(json_text(json)) + '\n';
  }
  folder.write("parts/catalogue.jsonl", changed);
  part.resume = true;
  CHECK(run_catalogue(part, [](CatalogueEntry&) {}).exit == ExitCode::expectation_failed);
}

TEST_CASE("The segments of all seeds are one sample for the rate") {
  const TemporaryFolder folder;
  const std::string sized = folder.write("sized.toml", test::small_scenario(""));
  const SizeSeedsOutcome outcome = size_seeds(sized, size_options(options(folder / "size")));
  REQUIRE(outcome.failure.empty());
  const SizeRecord& record = outcome.record;
  std::int64_t segments = 0;
  Duration most, longest_lead, longest_delay;
  for (std::uint64_t seed = 3; seed < 18; ++seed) {
    const ReadResult scenario = read_scenario(sized, {{}, seed});
    REQUIRE(scenario);
    SizeOptions alone;
    alone.rate = 0.02;
    const SizeRecord one = size_scenario(*scenario, alone).record;
    const auto of = std::find_if(one.strategies.begin(), one.strategies.end(),
                                 [](const SizeStrategy& strategy) { return strategy.name == "phase_locked"; });
    REQUIRE(of != one.strategies.end());
    REQUIRE(of->rate);
    segments += of->rate->segments;
    most = std::max(most, of->any_phase.latency);
    longest_lead = std::max(longest_lead, of->lead);
    longest_delay = std::max(longest_delay, of->any_phase.latency - of->lead);
  }
  const auto pooled = std::find_if(record.strategies.begin(), record.strategies.end(),
                                   [](const SizeStrategy& strategy) { return strategy.name == "phase_locked"; });
  REQUIRE(pooled != record.strategies.end());
  REQUIRE(pooled->rate);
  CHECK(pooled->rate->segments == segments);
  CHECK(segments > 100);
  CHECK(pooled->rate->allowed == segments * 2 / 100);
  CHECK(pooled->rate->any_phase.underruns <= pooled->rate->allowed);
  // One seed may set the lead of all and another seed the delay. But two segments in a hundred may be late.
  CHECK(pooled->rate->any_phase.latency.ns < (longest_lead + longest_delay).ns);
  // The same lines give the answer for another rate; nothing is run again.
  SizeSeedsOptions never = size_options(options(folder / "size", {}, true));
  never.rate = 1e-6;
  const SizeSeedsOutcome strict = size_seeds(sized, never);
  const auto strictest = std::find_if(strict.record.strategies.begin(), strict.record.strategies.end(),
                                      [](const SizeStrategy& strategy) { return strategy.name == "phase_locked"; });
  CHECK(strictest->rate->any_phase.latency.ns >= most.ns);
  CHECK(strictest->rate->any_phase.latency.ns == (longest_lead + longest_delay).ns);
  CHECK(strictest->rate->allowed == 0);
  CHECK_FALSE(strictest->rate->sure);
}

TEST_CASE("Seeds of a timing without variation and spans that are none are refused") {
  const TemporaryFolder folder;
  const SizeSeedsOutcome outcome =
      size_seeds(kScenarios + "paper/figure-1-spring.toml", size_options(options(folder / "size")));
  REQUIRE(outcome.errors.size() == 1);
  CHECK_THAT(outcome.errors.front().message, Contains("the same timing with every seed"));
  CHECK(parse_seeds("3..18")->first == 3);
  CHECK(parse_seeds("3..18")->second == 15);
  for (const char* wrong : {"", "3", "3..", "..3", "5..5", "6..5", "1..2x", "-1..2", "0..99999999999"})
    CHECK_THAT(parse_seeds(wrong).error(), Contains("is no span"));
}

TEST_CASE("The status of any work is read from its parts") {
  const TemporaryFolder folder;
  const std::string sized = folder.write("sized.toml", test::small_scenario(""));
  const Kind kind = kinds(sized)[1];
  kind.run(options(folder / "parts", {2, 3}));
  const auto status = parts_status(folder / "parts", "size");
  REQUIRE(status.ok());
  CHECK(status->items == 15);
  CHECK(status->done == 5);
  REQUIRE(status->parts.size() == 1);
  CHECK(status->parts[0].ended);
  CHECK_THAT(parts_status(folder / "parts", "study").error(), Contains("has no part of a study"));
  // The items of another division would be counted twice.
  kind.run(options(folder / "parts", {2, 4}));
  CHECK_THAT(parts_status(folder / "parts", "size").error(), Contains("is of 4 shards, but the files before it are of 3"));
}

TEST_CASE("The felt force and the stiffest scene merge from the shards of their strategies and cells", "[sweep]") {
  const TemporaryFolder folder;
  const auto [file, set, of] = GENERATE(table<std::string, std::vector<std::string>, int>(
      {{"paper/figure-1-spring.toml", {"study.repeats=1"}, 2}, {"closed-loop/price-study.toml", {}, 2}}));
  INFO(file);
  // Named captures: clang 14 captures no structured binding.
  const Kind kind{"study", 0,
                  [&scenario = file, &values = set](const PartOptions& part) { return study(scenario, values, part); }};
  const PartOutcome one = kind.run(options(folder / "one"));
  INFO(one.failure);
  REQUIRE(one.exit == ExitCode::pass);
  const std::string out = folder / "merged.jsonl";
  REQUIRE(merge_parts(shards(kind, folder, of), out).errors.empty());
  CHECK(certain(out) == certain(one.file));
  CHECK(one.items == 2);
}
