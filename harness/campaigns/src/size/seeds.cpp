// `evenstep size --rate --seeds`: the needs of every seed's segments, in shards, and the latency that their pool needs.
#include <fmt/format.h>

#include <charconv>
#include <map>

#include "evenstep/campaigns/size.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/trust.h"
#include "evenstep/harness/underrun_rate.h"
#include "rate.h"
#include "src/shards/json_parts.h"
#include "src/shards/lines.h"

namespace evenstep {
namespace {

using internal::MapNeeds;
using internal::SegmentNeed;

Json json_of(const std::vector<SegmentNeed>& needs) {
  Json out = Json::array();
  for (const SegmentNeed& need : needs) {
    out.push_back(need.lead.ns);
    out.push_back(need.delay.ns);
  }
  return out;
}

/// Calls add(need) for each.
template <class Add>
void each_need(const Json& json, Add add) {
  for (std::size_t i = 0; i + 1 < json.size(); i += 2)
    add(SegmentNeed{{json.at(i).get<std::int64_t>()}, {json.at(i + 1).get<std::int64_t>()}});
}

ReadResult read_seed(const std::string& path, const SizeSeedsOptions& options, std::int64_t item) {
  return read_scenario(path, {options.set, options.first_seed + static_cast<std::uint64_t>(item), options.registry});
}

/// Empty: interrupted.
std::string seed_line(const std::string& path, const SizeSeedsOptions& options, std::int64_t item) {
  if (options.interrupted && *options.interrupted) return {};
  const ReadResult scenario = read_seed(path, options, item);
  if (!scenario) throw std::runtime_error(text(scenario.error().front()));
  const MapSetup setup = map_setup(*scenario);
  const std::vector<SegmentTiming> segments = internal::segments_of(*scenario);
  Json needs = Json::object();
  for (const StrategyKind map : internal::maps_to_size(setup, options.other_maps)) {
    const MapNeeds of_map = internal::needs_of(setup, map, segments);
    needs[name_of(map)] = {{"any_phase", json_of(of_map.any_phase)}, {"this_phase", json_of(of_map.this_phase)}};
  }
  return internal::item_line(item, {{"seed", scenario->seed}, {"needs", needs}});
}

constexpr std::size_t kMostCorrelated = 1 << 16;  // segments that say how alike neighbours are

/// Of a map, over all lines of a file: how many segments, the first of them, and those that decide.
struct Pooled {
  std::int64_t segments = 0;
  std::vector<SegmentNeed> first;
  std::optional<internal::NeedPool> any_phase, this_phase;
};

/// Calls take(map, its needs) for every seed and map of a complete file.
template <class Take>
void each_map(const std::string& file, Take take) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  internal::PartLines lines(file, kPiece);
  lines.next();
  while (lines.next()) {
    const Json json = internal::read_json_line(lines.line(), [](Json all) { return all; });
    for (const auto& [map, needs] : json.at("needs").items()) take(map, needs);
  }
}

/// The file is read twice: the number of segments decides which of them must be kept.
void pool_all(const std::string& file, const SizeSeedsOptions& options, SizeRecord& record) {
  std::map<std::string, Pooled> maps;
  std::vector<std::string> names;  // in the order of the lines
  each_map(file, [&](const std::string& map, const Json& needs) {
    if (maps.count(map) == 0) names.push_back(map);
    Pooled& pooled = maps[map];
    pooled.segments += static_cast<std::int64_t>(needs.at("any_phase").size() / 2);
    if (pooled.first.size() < kMostCorrelated)
      each_need(needs.at("any_phase"), [&](const SegmentNeed& need) { pooled.first.push_back(need); });
  });
  for (auto& [map, pooled] : maps) {
    const std::int64_t allowed = internal::allowed_underruns(options.rate, pooled.segments);
    pooled.any_phase.emplace(allowed);
    pooled.this_phase.emplace(allowed);
  }
  each_map(file, [&](const std::string& map, const Json& needs) {
    Pooled& pooled = maps.at(map);
    each_need(needs.at("any_phase"), [&](const SegmentNeed& need) { pooled.any_phase->add(need); });
    each_need(needs.at("this_phase"), [&](const SegmentNeed& need) { pooled.this_phase->add(need); });
  });
  for (const std::string& map : names) {
    Pooled& pooled = maps.at(map);
    SizeStrategy strategy{map};
    const MapNeeds needs{pooled.any_phase->take(), pooled.this_phase->take()};
    // Seeds are draws of one process.
    strategy.trust = {.segments = pooled.segments, .alike = internal::alike_segments(pooled.first), .tested = true};
    if (pooled.segments > 0) strategy.rate = internal::rate_of(needs, strategy.trust, options.rate, options.confidence);
    record.segments = std::max(record.segments, pooled.segments);
    record.strategies.push_back(std::move(strategy));
  }
}

std::vector<Diagnostic> objections(const std::string& path, const SizeSeedsOptions& options) {
  const ReadResult first = read_seed(path, options, 0);
  if (!first) return first.error();
  if (first->case_spec) return {{path, 0, 0, "a [case] drives the solver without a loop: there is no latency to size"}};
  if (!internal::seeds_differ(*first))
    return {{path, 0, 0, "has the same timing with every seed: it is recorded, or nothing in it varies; leave out --seeds"}};
  return {};
}

}  // namespace

Result<std::pair<std::uint64_t, std::int64_t>> parse_seeds(const std::string& text) {
  std::uint64_t first = 0, end = 0;
  const char* const last = text.data() + text.size();
  const auto [dots, error] = std::from_chars(text.data(), last, first);
  if (error == std::errc{} && last - dots > 2 && dots[0] == '.' && dots[1] == '.') {
    const auto [at, wrong] = std::from_chars(dots + 2, last, end);
    if (wrong == std::errc{} && at == last && first < end && end - first <= static_cast<std::uint64_t>(kMostSweepPoints) &&
        end <= static_cast<std::uint64_t>(INT64_MAX))
      return std::pair(first, static_cast<std::int64_t>(end - first));
  }
  return Failure(
      fmt::format("\"{}\" is no span of at most {} seeds, such as \"0..1000\": the first, and the one after the last", text,
                  kMostSweepPoints));
}

SizeSeedsOutcome size_seeds(const std::string& path, const SizeSeedsOptions& options) {
  SizeSeedsOutcome outcome;
  outcome.errors = objections(path, options);
  internal::CampaignId id{
      "size", "", path, options.set, "",
  };
  if (outcome.errors.empty())
    id.scenario = internal::scenario_digest(path, {options.set, std::nullopt, options.registry}, outcome.errors);
  if (!outcome.errors.empty()) {
    outcome.exit = ExitCode::usage;
    return outcome;
  }
  id.name = read_seed(path, options, 0)->name;
  id.own = {{"rate", options.rate}, {"confidence", options.confidence}};
  const Json more = {
      {"seeds", fmt::format("{}..{}", options.first_seed, options.first_seed + static_cast<std::uint64_t>(options.seeds))},
      {"other_maps", options.other_maps}};
  internal::JsonParts parts(id, options.seeds, more, [](const Json& json) {  // so that a line without a meaning is refused
    for (const auto& [map, needs] : json.at("needs").items()) {
      for (const char* phase : {"any_phase", "this_phase"}) each_need(needs.at(phase), [](const SegmentNeed&) {});
    }
  });
  internal::run_part(
      parts, [&](std::int64_t item) { return seed_line(path, options, item); }, id.kind, options, outcome);
  if (outcome.exit != ExitCode::pass || options.shard.of > 1) return outcome;
  outcome.record.input = path;
  outcome.record.segments_from = "programmed";
  outcome.record.rate = options.rate;
  outcome.record.confidence = options.confidence;
  outcome.record.clean_segments = internal::chosen_segments_needed(options.rate, options.confidence, 1);
  pool_all(outcome.file, options, outcome.record);
  return outcome;
}

}  // namespace evenstep
