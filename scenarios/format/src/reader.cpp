#include <fmt/format.h>

#include <filesystem>

#include "evenstep/format/load.h"
#include "evenstep/format/reader.h"
#include "sections.h"

namespace evenstep {
namespace internal {

Table ScenarioReading::section(std::string_view name) const {
  return {document.find(name), std::string(name), document.place};
}

bool ScenarioReading::sound(std::string_view name) const { return check.sound(document.find(name)); }

std::string in_ms(Duration duration) { return fmt::format("{} ms", static_cast<double>(duration.ns) / 1e6); }

namespace {

/// The resolved table is stored elsewhere, and the files that it names must still be found from there.
void make_paths_absolute(Value& document) {
  for (Value* path : named_files(document)) {
    std::error_code ignored;
    path->text = std::filesystem::weakly_canonical(path_from(*path), ignored).string();
  }
}

/// A seed from the command line overrides that of the file.
void set_seed(Value& document, std::uint64_t seed, Errors& errors) {
  const Place place{"--seed", 0, 0};
  if (seed > INT64_MAX) return errors.add(place, fmt::format("{} is out of range; it must be at most {}", seed, INT64_MAX));
  apply_override(document, fmt::format("run.seed={}", seed), errors);
}

/// Motions, limits and units refer to each other, so the order of these calls matters.
void read_sections(ScenarioReading& reading) {
  read_strategies(reading);
  if (reading.document.find("case") != nullptr) {
    read_case(reading);
  } else {
    read_timing(reading);
    read_run(reading);
    read_devices(reading);
    read_scene(reading);
    read_rendering(reading);
    read_remap(reading);
    read_study(reading);
    read_sweep(reading);
  }
  read_expectations(reading);
  if (reading.errors.any()) return;
  const Table top{&reading.document, "", reading.document.place};
  reading.scenario.name = top.text("name");
  reading.scenario.because = top.text("because");
  for (const Value& tag : top.at("tags").list) reading.scenario.tags.push_back(tag.text);
}

void append_files(Value* value, std::vector<Value*>& files) {
  if (value == nullptr) return;
  if (value->is(Value::Kind::text)) files.push_back(value);
  for (Value& one : value->list) append_files(&one, files);
}

}  // namespace

bool names_file(std::string_view path) {
  return path == "timing.trace" ||
         (path.starts_with("device.") && (path.ends_with(".motion.file") || path.ends_with(".motion.path.file")));
}

std::vector<Value*> named_files(Value& document) {
  std::vector<Value*> files;
  if (Value* timing = document.find("timing")) append_files(timing->find("trace"), files);
  if (Value* devices = document.find("device")) {
    for (Value& device : devices->list) {
      Value* motion = device.find("motion");
      if (motion == nullptr) continue;
      append_files(motion->find("file"), files);
      if (Value* intended = motion->find("path")) append_files(intended->find("file"), files);
    }
  }
  Value* sweep = document.find("sweep");
  Value* grid = sweep == nullptr ? nullptr : sweep->find("grid");
  if (grid == nullptr) return files;
  for (Entry& axis : grid->table) {
    if (names_file(axis.key)) append_files(&axis.value, files);
  }
  return files;
}

Value load_with_overrides(const std::string& path, const ReadOptions& options, Errors& errors) {
  Value document = load_document(path, errors);
  if (errors.any()) return document;
  for (const std::string& assignment : options.set) apply_override(document, assignment, errors);
  if (options.seed) set_seed(document, *options.seed, errors);
  return document;
}

ReadResult read_document(Value document, const std::string& path, const Registry& registry) {
  Errors errors;
  Scenario scenario;
  scenario.file = path;
  const Check check(document, errors);
  ScenarioReading reading{document, check, errors, scenario, registry};
  read_sections(reading);
  if (errors.any()) return Failure(errors.sorted(path));
  make_paths_absolute(document);
  scenario.resolved_toml = print_toml(document);
  return scenario;
}

}  // namespace internal

ReadResult read_scenario(const std::string& path, const ReadOptions& options) {
  using namespace internal;
  Errors errors;
  Value document = load_with_overrides(path, options, errors);
  if (errors.any()) return Failure(errors.sorted(path));
  return read_document(std::move(document), path, options.registry);
}

}  // namespace evenstep
