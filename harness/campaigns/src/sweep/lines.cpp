#include "lines.h"

#include <fmt/format.h>

#include <charconv>
#include <stdexcept>

#include "src/shards/json.h"
#include "swarm.h"

namespace evenstep::internal {
namespace {

constexpr int kFormat = 1;
constexpr SweepVerdict kVerdicts[] = {SweepVerdict::pass, SweepVerdict::fail, SweepVerdict::error, SweepVerdict::skipped};

/// "0..30000" if the seeds are consecutive, otherwise a list.
Json json_of_seeds(const std::vector<std::uint64_t>& seeds) {
  for (std::size_t i = 1; i < seeds.size(); ++i) {
    if (seeds[i] != seeds[i - 1] + 1) return seeds;
  }
  return fmt::format("{}..{}", seeds.front(), seeds.back() + 1);
}

std::vector<std::uint64_t> read_seeds(const Json& json) {
  if (!json.is_string()) return json.get<std::vector<std::uint64_t>>();
  const std::string text = json.get<std::string>();
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) refuse_line("seeds are no span");
  const std::uint64_t first = std::stoull(text.substr(0, dots)), end = std::stoull(text.substr(dots + 2));
  if (first >= end || end - first > static_cast<std::uint64_t>(kMostSweepPoints)) refuse_line("seeds are no span");
  std::vector<std::uint64_t> seeds;
  for (std::uint64_t seed = first; seed < end; ++seed) seeds.push_back(seed);
  return seeds;
}

Json json_of_value(const SweepPoint::Value& judged) {
  Json out = Json::object();
  out["value"] = judged.value ? Json(*judged.value) : Json();
  if (judged.min) out["min"] = *judged.min;
  if (judged.max) out["max"] = *judged.max;
  out["verdict"] = name_of(judged.verdict);
  return out;
}

SweepVerdict read_verdict(const Json& json) {
  const std::string word = json.get<std::string>();
  for (const SweepVerdict verdict : kVerdicts) {
    if (word == name_of(verdict)) return verdict;
  }
  refuse_line(fmt::format("verdict \"{}\" is not known", word));
}

std::optional<double> read_number(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::nullopt;
  return found->get<double>();
}

/// The values of a point's grid, for people and other programs; they also follow from the index.
Json json_of_grid(const SweepHeader& header, std::int64_t index) {
  Json out = Json::object();
  for (std::size_t axis = 0; axis < header.grid.size(); ++axis)
    out[header.grid[axis].path] = shown_value(header.grid[axis].values[header.value_of(index, axis)]);
  return out;
}

std::string line_of(const Json& json) { return with_checksum(json_text(json)); }

SweepHeader read_header(const Json& json) {
  if (json.at("format").get<int>() != kFormat) refuse_line("is of another format");
  SweepHeader header;
  header.name = json.at("sweep").get<std::string>();
  header.file = json.at("file").get<std::string>();
  if (json.contains("set")) header.set = json.at("set").get<std::vector<std::string>>();
  header.scenario = json.at("scenario").get<std::string>();
  header.build = json.at("build").get<std::string>();
  header.seeds = read_seeds(json.at("seeds"));
  if (header.seeds.empty()) refuse_line("has no seeds");
  __int128 points = static_cast<__int128>(header.seeds.size());
  for (const auto& [path, values] : json.at("grid").items()) {
    header.grid.push_back({path, values.get<std::vector<std::string>>()});
    points *= static_cast<__int128>(header.grid.back().values.size());
    if (points < 1 || points > kMostSweepPoints) refuse_line("has no possible number of points");
  }
  for (const Json& expect : json.at("expect")) {
    header.expectations.push_back({expect.at("signal").get<std::string>(), expect.at("metric").get<std::string>(),
                                   expect.at("unit").get<std::string>()});
  }
  if (json.contains("sometimes")) {
    for (const Json& state : json.at("sometimes"))
      header.sometimes.push_back({state.at("name").get<std::string>(), state.at("signal").get<std::string>(),
                                  state.at("metric").get<std::string>()});
  }
  if (json.contains("swarm")) header.swarm = json.at("swarm").get<std::vector<std::string>>();
  if (json.contains("stop_after")) header.stop_after = json.at("stop_after").get<std::int64_t>();
  header.keep_worst = json.at("keep_worst").get<int>();
  if (json.contains("find")) {
    const Json& find = json.at("find");
    header.find = {find.at("axis").get<std::size_t>(), find.at("smallest").get<bool>(), find.at("gate").get<std::string>(),
                   find.at("allowed").get<std::size_t>()};
    if (header.find->axis >= header.grid.size() || header.find->allowed > header.grid[header.find->axis].values.size())
      refuse_line("finds a key that it does not have");
  }
  if (json.at("points").get<std::int64_t>() != header.points()) refuse_line("has another number of points than its grid");
  return header;
}

}  // namespace

std::string header_line(const SweepHeader& header, Shard shard) {
  Json json;
  json["format"] = kFormat;
  json["sweep"] = header.name;
  json["file"] = header.file;
  if (!header.set.empty()) json["set"] = header.set;
  json["scenario"] = header.scenario;
  json["build"] = header.build;
  json["points"] = header.points();
  json["seeds"] = json_of_seeds(header.seeds);
  json["grid"] = Json::object();
  for (const SweepHeader::Axis& axis : header.grid) json["grid"][axis.path] = axis.values;
  json["expect"] = Json::array();
  for (const SweepHeader::Expect& expect : header.expectations)
    json["expect"].push_back({{"signal", expect.signal}, {"metric", expect.metric}, {"unit", expect.unit}});
  for (const SweepHeader::Sometimes& state : header.sometimes)
    json["sometimes"].push_back({{"name", state.name}, {"signal", state.signal}, {"metric", state.metric}});
  if (!header.swarm.empty()) json["swarm"] = header.swarm;
  if (header.stop_after) json["stop_after"] = *header.stop_after;
  json["keep_worst"] = header.keep_worst;
  if (header.find) {
    json["find"] = {{"axis", header.find->axis},
                    {"smallest", header.find->smallest},
                    {"gate", header.find->gate},
                    {"allowed", header.find->allowed}};
  }
  if (shard.of > 1) json["shard"] = {shard.index, shard.of};
  return line_of(json);
}

std::string point_line(const SweepHeader& header, const SweepPoint& point) {
  Json json;
  json["index"] = point.index;
  json["seed"] = header.seed_of(point.index);
  json["grid"] = json_of_grid(header, point.index);
  json["verdict"] = name_of(point.verdict);
  json["trace"] = fmt::format("{:016x}", point.trace_hash);
  json["expect"] = Json::array();
  for (const SweepPoint::Value& judged : point.expect) json["expect"].push_back(json_of_value(judged));
  if (!header.swarm.empty()) json["faults"] = point.faults_on;
  if (!header.sometimes.empty()) json["sometimes"] = point.reached;
  if (!point.failure.empty()) json["failure"] = point.failure;
  return line_of(json);
}

HeaderLine read_header_line(const std::string& line) {
  return read_json_line(line, [](const Json& json) { return HeaderLine{read_header(json), read_shard(json)}; });
}

SweepPoint read_point_line(const SweepHeader& header, const std::string& line) {
  return read_json_line(line, [&](const Json& json) {
    SweepPoint point;
    point.index = json.at("index").get<std::int64_t>();
    if (point.index < 0 || point.index >= header.points())
      refuse_line(fmt::format("has the number {} of no point", point.index));
    if (json.at("seed").get<std::uint64_t>() != header.seed_of(point.index) ||
        json.at("grid") != json_of_grid(header, point.index))
      refuse_line(fmt::format("has other values than point {}", point.index));
    point.verdict = read_verdict(json.at("verdict"));
    if (point.verdict == SweepVerdict::skipped) refuse_line("has a verdict that only an expectation can have");
    if (!header.swarm.empty()) {
      point.faults_on = json.at("faults").get<std::vector<std::string>>();
      if (point.faults_on != faults_on(header.swarm, header.seed_of(point.index)))
        refuse_line(fmt::format("has other faults than point {}", point.index));
    }
    if (!header.sometimes.empty()) point.reached = json.at("sometimes").get<std::vector<bool>>();
    if (!point.reached.empty() && point.reached.size() != header.sometimes.size())
      refuse_line("has another number of states than the header");
    const std::string trace = json.at("trace").get<std::string>();
    const auto [at, error] = std::from_chars(trace.data(), trace.data() + trace.size(), point.trace_hash, 16);
    if (error != std::errc{} || at != trace.data() + trace.size()) refuse_line("has no trace hash");
    for (const Json& judged : json.at("expect")) {
      point.expect.push_back({read_number(judged, "value"), read_number(judged, "min"), read_number(judged, "max"),
                              read_verdict(judged.at("verdict"))});
    }
    if (!point.expect.empty() && point.expect.size() != header.expectations.size())
      refuse_line("has another number of expectations than the header");
    if (json.contains("failure")) point.failure = json.at("failure").get<std::string>();
    if (point_line(header, point) != line) refuse_line(kNotOurs);
    return point;
  });
}

std::unique_ptr<PartItem> SweepParts::read(const std::string& line) const {
  auto item = std::make_unique<SweepItem>();
  item->point = read_point_line(header_, line);
  item->index = item->point.index;
  item->failed = item->point.verdict != SweepVerdict::pass;
  return item;
}

void SweepParts::take(const PartItem& item) { summarizer_.add(static_cast<const SweepItem&>(item).point); }

ExitCode exit_of(const SweepSummary& summary) {
  const bool missed = summary.untested();
  if (summary.find) return summary.find->within_gate && !missed ? ExitCode::pass : ExitCode::expectation_failed;
  if (summary.all.errors > 0) return ExitCode::run_failed;
  return summary.all.failed > 0 || missed ? ExitCode::expectation_failed : ExitCode::pass;
}

}  // namespace evenstep::internal
