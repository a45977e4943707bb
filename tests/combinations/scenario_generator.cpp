#include "scenario_generator.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <span>

namespace evenstep::testing {
namespace {

using internal::Field;
using internal::fields;
using internal::kind_key;
using internal::split_words;
using internal::subtable;

/// Values for keys whose example says nothing to a random scenario: texts that must name something, and sizes that keep a
/// run short. Every other key takes its example, or that example times a factor.
const std::map<std::string_view, std::vector<std::string_view>>& hints() {
  static const std::map<std::string_view, std::vector<std::string_view>> values{
      {"format", {"1"}},
      {"run.duration", {"\"0.4 s\"", "\"0.7 s\"", "\"1.1 s\"", "\"32 segments\""}},
      {"run.warmup", {"\"0.1 s\"", "\"0.2 s\"", "\"3 segments\""}},
      {"run.seed", {"0", "1", "7", "9223372036854775807"}},
      {"timing.segment", {"\"30 Hz\"", "\"60 Hz\"", "\"20 ms\"", "\"33.3 ms\""}},
      {"timing.visualization", {"\"11.1 ms\"", "\"4 ms\"", "\"8.4 ms\"", "\"0 ms\"", "\"render 5 ms\""}},
      {"timing.steps", {"15", "7", "1", "[3, 4, 5]", "[2, 9]"}},
      {"timing.step", {"\"fill\"", "\"1 ms\"", "\"1.48 ms\"", "\"0.3 ms\""}},
      {"timing.picture", {"[64, 48]"}},
      {"timing.trace", {"\"steps.csv\"", "\"odd.csv\"", "\"profile.csv\""}},
      {"timing.repeat", {"1", "2", "9"}},
      {"timing.roles.visualization", {"\"draw\""}},
      {"timing.roles.step", {"\"solve\""}},
      {"timing.roles.step_begin", {"\"solve\""}},
      {"timing.roles.segment", {"\"draw\""}},
      {"timing.roles.name", {"\"what\""}},
      {"timing.roles.begin", {"\"start\""}},
      {"timing.roles.end", {"\"stop\""}},
      {"timing.roles.duration", {"\"length\""}},
      {"timing.roles.unit", {"\"ns\""}},
      {"timing.roles.format", {"\"csv\""}},
      {"timing.roles.steps", {"0"}},
      {"timing.loop", {"\"segments\""}},
      {"timing.jitter_fix", {"0", "0.5", "1"}},
      {"timing.refresh_jitter", {"\"0.1 ms\"", "\"1 ms\""}},
      {"timing.changes.steps", {"15", "3", "[2, 4]"}},
      {"scene.lattice", {"[4, 4, 4]", "[3, 4, 5]"}},
      {"scene.particles", {"50", "64"}},
      {"scene.step_size", {"\"fill\"", "\"1 ms\"", "\"2 ms\"", "\"450 Hz\""}},
      {"scene.substeps", {"\"auto\"", "1", "4", "20"}},
      {"scene.iterations", {"5", "20"}},
      {"scene.command", {"[\"cat\"]"}},
      {"scene.directory", {"\".\""}},
      {"scene.name", {"\"my-spring\""}},
      {"scene.options", {"{ stiffness = 200 }"}},
      {"case.foreign.name", {"\"my-spring\""}},
      {"case.foreign.options", {"{ stiffness = 200 }"}},
      {"timing.foreign.name", {"\"my-gpu\""}},
      {"device.foreign.name", {"\"my-arm\""}},
      {"remap.foreign.name", {"\"my-pacer\""}},
      {"device.name", {"\"left\"", "\"right\""}},
      {"device.rate", {"\"1 kHz\"", "\"500 Hz\"", "\"2 kHz\"", "\"1000/3 Hz\""}},
      {"device.phase", {"\"0 ms\"", "\"0.3 ms\"", "\"0.9 ms\""}},
      {"device.grab.center", {"[\"7.5 mm\", \"7.5 mm\", \"15 mm\"]", "[\"0 mm\", \"0 mm\", \"15 mm\"]"}},
      {"device.motion.file", {"\"hand.csv\""}},
      {"device.motion.path.file", {"\"hand.csv\""}},
      {"device.pid.travel", {"[\"0.2 m\", \"0.2 m\", \"0 m\"]"}},
      {"device.evdev.travel", {"[\"0.2 m\", \"0.2 m\", \"0 m\"]"}},
      {"remap.latency", {"\"minimal\"", "\"minimal-this-phase\"", "\"adaptive\"", "\"20 ms\"", "\"45 ms\"", "\"5 ms\""}},
      {"remap.lead", {"\"minimal\"", "\"minimal-this-phase\"", "\"20 ms\"", "\"-3 ms\""}},
      {"expect.signal", {"\"left.force.*\"", "\"left.interaction.*\"", "\"left.force.phase_locked\"", "\"*.force.direct\""}},
      {"expect.metric",
       {"\"late\"", "\"underruns\"", "\"velocity_jump\"", "\"jump_max\"", "\"deviation_max\"", "\"underrun_rate\""}},
      {"expect.equals", {"0"}},
      {"expect.max", {"0", "10", "\"12 step\""}},
      {"expect.min", {"0", "1", "\"0 step\""}},
      {"sometimes.signal", {"\"left.force.*\""}},
      {"sometimes.metric", {"\"late\"", "\"underruns\""}},
      {"case.values", {"[1, 10]", "[0.01]", "[0.5, 1, 2]"}},
      {"case.periods", {"3", "10"}},
      {"case.most_steps", {"100", "1"}},
      {"case.duration", {"\"10 ms\""}},
      {"case.particles", {"4", "8"}},
      {"study.duration", {"\"50 ms\"", "\"0.1 s\""}},
      {"study.repeats", {"1"}},
      {"study.iterations", {"[5]", "[3, 9]"}},
      {"sweep.seeds", {"3", "[1, 2]", "\"0..3\"", "[\"1..3\", 7]"}},
      {"sweep.stop_after", {"1", "5"}},
      {"sweep.grid.*", {"[\"15 ms\", \"30 ms\"]", "[\"45 ms\"]"}},
      {"sweep.find.smallest", {"\"remap.latency\""}},
      {"sweep.find.largest", {"\"remap.latency\""}},
  };
  return values;
}

/// These tables are found more often than their share of the keys, because what is programmed there is what a run is about.
double weight_of(std::string_view table) {
  static const std::map<std::string_view, double> weights{{"run.strategies", 4},
                                                          {"remap", 4},
                                                          {"scene.lattice", 1e9},
                                                          {"scene.spacing", 0.2},
                                                          {"expect", 5},
                                                          {"device.motion", 5},
                                                          {"device.render", 2},
                                                          {"timing.jitter", 3},
                                                          {"device.pid.travel", 1e9},
                                                          {"device.evdev.travel", 1e9},
                                                          {"device.pid.wheel", 0.2},
                                                          {"device.evdev.wheel", 0.2}};
  const auto found = weights.find(table);
  return found == weights.end() ? 1 : found->second;
}

/// What a key or table has no meaning without, where chance would take long to find it: another key, and its value if it
/// must have a certain one.
struct Companion {
  std::string_view of, key, toml;
};
constexpr Companion kCompanions[] = {
    {"timing.picture", "timing.visualization", "\"render 5 ms\""},
    {"timing.roles.duration", "timing.roles.end", "-"},
    {"timing.roles.step_time", "timing.roles.step", "-"},
    {"timing.roles.step_time", "timing.roles.steps", "3"},
    {"timing.roles", "timing.trace", "\"profile.csv\""},
    {"timing.roles", "timing.roles.visualization", ""},
    {"timing.roles", "timing.roles.step", ""},
    {"timing.roles", "timing.roles.name", ""},
    {"timing.roles", "timing.roles.begin", ""},
    {"timing.roles", "timing.roles.end", ""},
    {"device.pid.wheel", "device.pid.travel", "-"},
    {"device.pid.wheel", "device.pid.full_scale", "-"},
    {"device.evdev.wheel", "device.evdev.travel", "-"},
    {"device.evdev.wheel", "device.evdev.full_scale", "-"},
    {"timing.governor.forecast", "timing.governor.over_budget", "\"skip\""},
    {"timing.governor.forecast", "timing.governor.budget", ""},
    {"study.stiffness_limit", "device.motion", ""},
    {"study.stiffness_limit", "device.motion.kind", "\"hand\""},
    {"study.step_sizes", "scene.kind", "\"tissue\""},
    {"sweep", "sweep.grid", ""},
    {"sweep", "remap", ""},
    {"sweep", "remap.latency", ""},
    {"sweep", "expect", ""},
    {"sweep.find.at_most", "sweep.find.smallest", ""},
    {"sweep.find.at_least", "sweep.find.largest", ""},
    {"expect.at", "case", ""},
    {"expect.at", "expect.signal", "\"case.symplectic-euler.*\""},
    {"expect.at", "expect.metric", "\"refused\""},
    {"expect.at", "expect.max", "1"},
    {"expect.confidence", "expect.metric", "\"underrun_rate\""},
    {"expect.confidence", "expect.max", "\"50 %\""},
    {"expect.seeds", "expect.confidence", ""},
    {"expect.seeds", "expect.metric", "\"underrun_rate\""},
    {"expect.seeds", "expect.max", "\"50 %\""},
};

bool has_kind(const Field& field, std::string_view kind) {
  const std::vector<std::string_view> kinds = split_words(field.kinds);
  return kinds.empty() || std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

/// The key that says that a table is of this kind.
std::string_view key_of_kind(std::string_view table, std::string_view kind) {
  return table == "timing" && kind == "accumulator" ? "loop" : kind_key(table);
}

/// These name files, shared objects, or faults of the scenario.
bool names_what_is_not_there(const Field& field) {
  return field.key == "extends" || field.key == "faults_off" || field.key == "library" ||
         (field.key == "options" && field.meaning.starts_with("With `library`"));
}

/// `toml` with its first number times `factor`, with three digits.
std::string scaled(std::string_view toml, double factor, bool whole) {
  const std::size_t from = toml.find_first_of("0123456789");
  if (from == std::string_view::npos) return std::string(toml);
  std::size_t length = 0;
  const double number = std::stod(std::string(toml.substr(from)), &length) * factor;
  const std::size_t to = from + length;
  const std::string text = whole ? fmt::format("{}", std::max(1LL, std::llround(number)))
                                 : fmt::format("{}", std::stod(fmt::format("{:.3g}", number)));
  return std::string(toml.substr(0, from)) + text + std::string(toml.substr(to));
}

}  // namespace

std::string name_of(const Field& field) {
  return field.table.empty() ? std::string(field.key) : fmt::format("{}.{}", field.table, field.key);
}

ScenarioGenerator::ScenarioGenerator(std::uint64_t seed, std::string folder, Registry registry)
    : random_(seed), folder_(std::move(folder)) {
  options_.registry = std::move(registry);
}

bool ScenarioGenerator::is_wanted(std::string_view table, std::string_view key) const {
  if (!wanted_) return false;
  if (wanted_->table == table && wanted_->key == key) return true;
  const std::string inner = table.empty() ? std::string(key) : fmt::format("{}.{}", table, key);
  return wanted_->table == inner || wanted_->table.starts_with(inner + '.');
}

const std::string_view* ScenarioGenerator::companion(std::string_view table, std::string_view key) const {
  const std::string name = table.empty() ? std::string(key) : fmt::format("{}.{}", table, key);
  for (const Companion& one : kCompanions) {
    const std::string wanted = wanted_ ? name_of(*wanted_) : "";
    if (one.key == name && (wanted == one.of || wanted.starts_with(std::string(one.of) + '.'))) return &one.toml;
  }
  return nullptr;
}

std::string ScenarioGenerator::kind_of(std::string_view table) {
  if (wanted_ && table.empty()) {
    for (const Field& field : fields())
      if (field.table.empty() && is_wanted("", field.key) && field.key != "run" && !field.kinds.empty())
        return std::string(field.kinds);
    if (is_wanted("", "case") || companion("", "case")) return "case";
  }
  if (table.empty()) return chance(0.9) ? "loop" : "case";
  for (const std::string_view own : {"trace", "foreign"})  // kinds of [timing] that are keys
    if (table == "timing" && (is_wanted(table, own) || companion(table, own))) return std::string(own);
  if (const std::string_view* const toml = companion(table, kind_key(table)); toml && !toml->empty())
    return std::string(toml->substr(1, toml->size() - 2));
  std::vector<std::string> kinds;
  const auto offer = [&](std::string_view kind) {
    for (const Field& field : fields())
      if (wanted_ && field.table == table && is_wanted(table, field.key) && (&field == wanted_ || wanted_->table != table) &&
          !has_kind(field, kind))
        return;
    kinds.emplace_back(kind);
  };
  const std::string_view key = kind_key(table);
  for (const Field& field : fields()) {
    if (field.table != table || field.key != key || field.words.empty()) continue;
    for (const std::string_view word : split_words(field.words))
      if (word != "foreign" || (wanted_ && wanted_->table.starts_with(table))) offer(word);
    break;
  }
  if (table == "timing") offer("trace"), offer("foreign"), offer("accumulator");
  if (kinds.empty()) return "";
  // The first one is the plainest, and the most common.
  if (chance(0.3)) return kinds.front();
  return kinds[below(kinds.size())];
}

std::string ScenarioGenerator::value_of(const Field& field) {
  if (const std::string_view* const toml = companion(field.table, field.key); toml && !toml->empty())
    return std::string(*toml);
  if (const auto hint = hints().find(name_of(field)); hint != hints().end())
    return std::string(hint->second[below(hint->second.size())]);
  const bool has_numbers = (field.forms & (internal::kInteger | internal::kNumber | internal::kDuration | internal::kSpan |
                                           internal::kRate | internal::kQuantity)) != 0;
  if ((field.forms & internal::kWord) && (!has_numbers || chance(0.5))) {
    const std::vector<std::string_view> words = split_words(field.words);
    const auto word = [&] { return fmt::format("\"{}\"", words[below(words.size())]); };
    if (field.shape == internal::Shape::one || (field.shape == internal::Shape::one_or_list && chance(0.5))) return word();
    std::vector<std::string> chosen;
    for (std::uint64_t i = 0; i <= below(3); ++i)
      if (std::string one = word(); one != "\"foreign\"" && std::find(chosen.begin(), chosen.end(), one) == chosen.end())
        chosen.push_back(std::move(one));
    return fmt::format("[{}]", fmt::join(chosen, ", "));
  }
  if (field.forms & internal::kBoolean) return chance(0.5) ? "true" : "false";
  const std::string example = internal::example_of(field);
  if (!has_numbers || chance(0.3)) return example;
  // A run takes a second: what an example of a run of many has at 2 s comes at 0.1 to 0.8 s.
  const bool is_long =
      example.find(" s\"") != std::string::npos && scaled(example, 1, false).find("0.") == std::string::npos;
  const double factor = is_long ? 0.05 + 0.35 * static_cast<double>(below(1000)) / 1000
                                : std::pow(2.0, static_cast<double>(below(2001)) / 1000 - 1);
  return scaled(example, factor, (field.forms & internal::kInteger) && !(field.forms & internal::kNumber));
}

/// The kind of these is a key of that name.
bool ScenarioGenerator::is_kind_key(const Field& field) {
  return (field.table.empty() && field.key == "case") ||
         (field.table == "timing" && (field.key == "trace" || field.key == "foreign"));
}

ScenarioTable::Entry ScenarioGenerator::entry_of(const Field& field, const std::string& kind) {
  ScenarioTable::Entry entry;
  entry.key = field.key == "*" ? "remap.latency" : field.key;  // of a grid: a key of the scenario
  const bool only_table = (field.forms & internal::kTable) != 0 && (field.forms & ~std::uint32_t{internal::kTable}) == 0;
  if (!only_table && !(wanted_ && wanted_->table == subtable(field))) {
    const bool is_kind = field.key == key_of_kind(field.table, kind) && !kind.empty() && !field.words.empty();
    entry.toml = is_kind ? fmt::format("\"{}\"", kind) : value_of(field);
    return entry;
  }
  entry.is_list = field.shape == internal::Shape::list || (field.shape == internal::Shape::one_or_list && field.key != "*");
  const std::uint64_t count = entry.is_list && chance(0.3) ? 2 : 1;
  for (std::uint64_t i = 0; i < count; ++i) {
    entry.tables.push_back(table(subtable(field)));
    if (field.key == "device") entry.tables.back().set("name", i == 0 ? "\"left\"" : "\"right\"");
  }
  return entry;
}

ScenarioTable ScenarioGenerator::table(std::string_view name) {
  ScenarioTable out;
  const std::string kind = kind_of(name);
  for (const Field& field : fields()) {
    if (field.table != name || !has_kind(field, kind) || out.has(field.key)) continue;
    if (is_kind_key(field) ? field.key != kind : names_what_is_not_there(field)) continue;
    const std::string_view* const beside = companion(name, field.key);
    if (beside && *beside == "-") continue;
    const bool is_kind = field.key == key_of_kind(name, kind) && !kind.empty() && !field.words.empty();
    if (is_kind && (kind == "trace" || kind == "foreign") && name == "timing") continue;
    const bool needed = field.required || is_kind_key(field) || (is_kind && kind != split_words(field.words).front()) ||
                        beside || (is_wanted(name, field.key) && (wanted_->table != name || wanted_ == &field));
    if (needed || chance(std::min(1.0, richness_ * weight_of(name_of(field))))) out.entries.push_back(entry_of(field, kind));
  }
  return out;
}

/// What the reader finds wrong in a line is drawn again if it must be there, or else left out.
void ScenarioGenerator::repair(GeneratedScenario& scenario) {
  std::map<std::string, int> tries;
  for (int round = 0; round < 80; ++round) {
    ScenarioText text = to_text(scenario.root);
    scenario.toml = text.toml;
    const std::string path = folder_ + "/scenario.toml";
    std::ofstream(path) << text.toml;
    const ReadResult read = read_scenario(path, options_);
    scenario.is_valid = static_cast<bool>(read);
    if (read) return;
    // One at a time, because a change moves the lines.
    const Diagnostic& error = read.error()[below(read.error().size())];
    if (error.line < 1 || static_cast<std::size_t>(error.line) > text.places.size()) {
      draw_section_again(scenario);  // something is missing
    } else {
      repair_at(scenario, text.places[static_cast<std::size_t>(error.line) - 1], tries);
    }
  }
}

void ScenarioGenerator::repair_at(GeneratedScenario& scenario, const ScenarioPlace& at, std::map<std::string, int>& tries) {
  const Field* found = nullptr;  // which key it is in the field table
  for (const Field& field : fields()) {
    if (field.key != at.key && field.key != "*") continue;
    const std::vector<ScenarioTable*> tables = tables_at(scenario.root, field.table);
    if (std::find(tables.begin(), tables.end(), at.table) != tables.end()) found = &field;
    if (found && found == wanted_) break;
  }
  const int count = ++tries[fmt::format("{} {}", found ? name_of(*found) : at.key, at.element)];
  const bool must_stay = found && (found->required || companion(found->table, found->key) || is_kind_key(*found) ||
                                   is_wanted(found->table, found->key));
  if (!found || (!must_stay && (count >= 3 || chance(0.5)))) {
    ScenarioTable::Entry& entry = *at.table->find(at.key);
    if (entry.tables.size() > 1) {
      entry.tables.erase(entry.tables.begin() + static_cast<std::ptrdiff_t>(at.element));
    } else {
      at.table->erase(at.key);
    }
  } else if (must_stay && count >= 3 && chance(0.5)) {
    draw_section_again(scenario);  // what stands elsewhere excludes it
  } else {
    *at.table->find(at.key) = entry_of(*found, kind_of(found->table));
  }
}

void ScenarioGenerator::draw_section_again(GeneratedScenario& scenario) {
  std::vector<const Field*> sections;
  for (const Field& field : fields())
    if (field.table.empty() && (field.forms & internal::kTable) && !is_kind_key(field) && has_kind(field, kind_of("")))
      sections.push_back(&field);
  const Field& section = *sections[below(sections.size())];
  ScenarioTable::Entry drawn = entry_of(section, "");
  if (ScenarioTable::Entry* const entry = scenario.root.find(section.key)) {
    *entry = std::move(drawn);
  } else {
    scenario.root.entries.push_back(std::move(drawn));
  }
}

GeneratedScenario ScenarioGenerator::drawn(double richness, const Field* wanted) {
  richness_ = richness;
  wanted_ = wanted;
  GeneratedScenario scenario;
  scenario.root = table("");
  scenario.root.set("format", "1");
  return scenario;
}

GeneratedScenario ScenarioGenerator::unrepaired(double richness) {
  GeneratedScenario scenario = drawn(richness, nullptr);
  scenario.toml = to_text(scenario.root).toml;
  return scenario;
}

GeneratedScenario ScenarioGenerator::scenario(double richness) {
  GeneratedScenario scenario = drawn(richness, nullptr);
  repair(scenario);
  return scenario;
}

GeneratedScenario ScenarioGenerator::scenario_with(const Field& wanted, double richness) {
  GeneratedScenario scenario = drawn(richness, &wanted);
  repair(scenario);
  return scenario;
}

void write_recordings(const std::string& folder) {
  std::ofstream steps(folder + "/steps.csv"), odd(folder + "/odd.csv"), hand(folder + "/hand.csv"),
      profile(folder + "/profile.csv");
  steps << "segment,kind,index,begin_ns,end_ns\n";
  for (std::int64_t segment = 0, at = 0; segment < 30; ++segment) {
    const std::int64_t drawing = 8'000'000 + segment % 4 * 1'500'000;
    steps << fmt::format("{},visualization,0,{},{}\n", segment, at, at + drawing);
    at += drawing;
    for (int step = 0; step < 12 + segment % 3; ++step, at += 1'480'000)
      steps << fmt::format("{},step,{},{},{}\n", segment, step, at, at + 1'480'000);
  }
  // Segments without a step, without a drawing, with one step, and a pause that is neither.
  odd << "segment,kind,index,begin_ns,end_ns\n"
         "0,visualization,0,0,9000000\n0,step,0,9000000,10500000\n0,step,1,10500000,12000000\n"
         "1,visualization,0,12000000,30000000\n"
         "2,step,0,30000000,31000000\n"
         "3,visualization,0,31000000,36000000\n3,idle,0,36000000,39000000\n3,step,0,39000000,45000000\n"
         "4,visualization,0,52000000,60000000\n4,step,0,60000000,61000000\n4,step,1,61500000,62500000\n";
  profile << "what,start,stop,length\n";
  for (std::int64_t at = 0; at < 900'000'000; at += 30'000'000) {
    profile << fmt::format("draw,{},{},{}\n", at, at + 10'000'000, 10'000'000);
    for (std::int64_t step = at + 10'000'000; step < at + 29'000'000; step += 2'000'000)
      profile << fmt::format("solve,{},{},{}\n", step, step + 1'500'000, 1'500'000);
  }
  hand << "t_s,x_m,y_m,z_m\n0,0,0,0\n0.1,0.001,0,0\n0.25,0.004,0.001,0\n1.5,0.02,0.002,0.001\n";
}

}  // namespace evenstep::testing
