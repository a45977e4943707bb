#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "evenstep/format/fields.h"
#include "evenstep/format/load.h"
#include "evenstep/format/reader.h"
#include "evenstep/text/suggest.h"
#include "faults.h"
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
  set_value(document, "run.seed", integer_value(static_cast<std::int64_t>(seed), place), errors);
}

/// Adds an error if the scene has nothing that can be drawn.
void check_drawing(ScenarioReading& reading) {
  if (reading.errors.any() || reading.scenario.timing.work != VisualizationWork::render) return;
  if (std::holds_alternative<TissueScene>(reading.scenario.scene.body)) return;
  reading.errors.add(
      reading.section("timing").place("visualization"),
      "'visualization': \"render\" draws a tissue, and this scene has none; write \"burn 11.1 ms\", which keeps "
      "the compute device busy, or a time");
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
    check_drawing(reading);
    read_rendering(reading);
    read_remap(reading);
    read_playing(reading);
    read_study(reading);
    read_sweep(reading);
    read_faults(reading);
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

/// A scene may be called by the name of a registered solver: that means kind = "foreign" with this name. A name that is
/// nearly such a name is read alike, because the error then says which one it may be.
void resolve_kind(Value& document, const Registry& registry) {
  Value* scene = document.find("scene");
  Value* kind = scene == nullptr ? nullptr : scene->find("kind");
  if (kind == nullptr || scene->find("name") != nullptr) return;
  const auto row = std::find_if(fields().begin(), fields().end(),
                                [](const Field& field) { return field.table == "scene" && field.key == "kind"; });
  const std::vector<std::string_view> own = split_words(row->words);
  std::vector<std::string_view> registered;
  for (const auto& [name, make] : registry.solvers()) registered.push_back(name);
  if (std::find(own.begin(), own.end(), kind->text) != own.end()) return;
  if (!registry.solvers().contains(kind->text) &&
      (nearest(kind->text, registered).empty() || !nearest(kind->text, own).empty()))
    return;
  Entry name{"name", kind->place, *kind};
  kind->text = "foreign";
  scene->table.push_back(std::move(name));
}

/// The value at these keys, one within the other; nullptr if there is none.
Value* below(Value* table, std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) table = table == nullptr ? nullptr : table->find(key);
  return table;
}

/// `library` of a device, map or timing source, and its `options`, stand for foreign = { library = ..., options = ... }.
void resolve_library(Value* table, Errors& errors) {
  const Value* library = below(table, {"library"});
  const Value* options = below(table, {"options"});
  if (library == nullptr && options == nullptr) return;
  if (library == nullptr)
    return errors.add(options->place,
                      "'options' is about a 'library', and there is none; write library = \"libmine.so\", "
                      "or the options in foreign = {}");
  if (table->find("foreign") != nullptr)
    return errors.add(library->place, "'library' does not go with 'foreign', which has one of its own; remove one of them");
  Entry foreign{"foreign", library->place, {}};
  foreign.value.place = library->place;
  const auto moved = std::stable_partition(table->table.begin(), table->table.end(), [](const Entry& entry) {
    return entry.key != "library" && entry.key != "options";
  });
  std::move(moved, table->table.end(), std::back_inserter(foreign.value.table));
  table->table.erase(moved, table->table.end());
  table->table.push_back(std::move(foreign));
}

void resolve_libraries(Value& document, Errors& errors) {
  for (const char* part : {"remap", "timing"}) resolve_library(document.find(part), errors);
  Value* devices = document.find("device");
  if (devices == nullptr) return;
  for (Value& device : devices->list) {
    const Value* library = device.find("library");
    if (library != nullptr && device.find("driver") == nullptr)
      device.table.push_back({"driver", library->place, text_value("foreign", library->place)});
    resolve_library(&device, errors);
  }
}

/// A command runs in the folder of the file that names it, also when the table is stored elsewhere.
void set_directory(Value& document) {
  const Value* command = below(&document, {"scene", "command"});
  if (command == nullptr) return;
  Value* directory = below(&document, {"scene", "directory"});
  std::error_code ignored;
  const auto absolute = [&](const Value& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path_from(path)), ignored).string();
  };
  if (directory == nullptr) {
    const Value here = text_value(absolute(text_value(".", command->place)), command->place);
    document.find("scene")->table.push_back({"directory", command->place, here});
  } else if (directory->is(Value::Kind::text) && !directory->text.empty()) {
    directory->text = absolute(*directory);
  }
}

}  // namespace

bool names_file(std::string_view path) {
  return path == "timing.trace" || path == "scene.library" || path.ends_with(".foreign.library") ||
         (path.starts_with("device.") && (path.ends_with(".motion.file") || path.ends_with(".motion.path.file")));
}

namespace {

bool names_library(std::string_view path) { return path == "scene.library" || path.ends_with(".foreign.library"); }

void append_grid_files(Value& document, bool libraries, std::vector<Value*>& files) {
  Value* grid = below(&document, {"sweep", "grid"});
  if (grid == nullptr) return;
  for (Entry& axis : grid->table) {
    if (names_file(axis.key) && names_library(axis.key) == libraries) append_files(&axis.value, files);
  }
}

}  // namespace

std::vector<Value*> data_files(Value& document) {
  std::vector<Value*> files;
  append_files(below(&document, {"timing", "trace"}), files);
  if (Value* devices = document.find("device")) {
    for (Value& device : devices->list) {
      append_files(below(&device, {"motion", "file"}), files);
      append_files(below(&device, {"motion", "path", "file"}), files);
    }
  }
  append_grid_files(document, false, files);
  return files;
}

std::vector<Value*> library_files(Value& document) {
  std::vector<Value*> files;
  append_files(below(&document, {"scene", "library"}), files);
  append_files(below(&document, {"timing", "foreign", "library"}), files);
  append_files(below(&document, {"remap", "foreign", "library"}), files);
  if (Value* devices = document.find("device")) {
    for (Value& device : devices->list) append_files(below(&device, {"foreign", "library"}), files);
  }
  append_grid_files(document, true, files);
  return files;
}

std::vector<Value*> named_files(Value& document) {
  std::vector<Value*> files = data_files(document);
  for (Value* const library : library_files(document)) files.push_back(library);
  return files;
}

CommandFiles files_of_command(Value& document) {
  const Value* command = below(&document, {"scene", "command"});
  CommandFiles files{below(&document, {"scene", "directory"}), {}};
  if (command == nullptr || files.directory == nullptr) return {};
  for (const Value& word : command->list) {
    if (&word == &command->list.front() && word.text.find('/') == std::string::npos) continue;  // looked for in PATH
    const std::filesystem::path file = std::filesystem::path(files.directory->text) / word.text;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) files.files.push_back(file.string());
  }
  return files;
}

Value load_with_overrides(const std::string& path, const ReadOptions& options, Errors& errors) {
  Value document = load_document(path, errors);
  if (errors.any()) return document;
  apply_overrides(document, options.set, errors);
  if (options.seed) set_seed(document, *options.seed, errors);
  resolve_libraries(document, errors);
  set_directory(document);
  return document;
}

ReadResult read_document(Value document, const std::string& path, const Registry& registry, bool real_time) {
  Errors errors;
  Scenario scenario;
  scenario.file = path;
  resolve_kind(document, registry);
  Value whole = document;  // what is stored still has the faults that are switched off
  switch_off_faults(document, errors);
  const Check check(document, errors);
  ScenarioReading reading{document, check, errors, scenario, registry, real_time};
  read_sections(reading);
  if (errors.any()) return Failure(errors.sorted(path));
  make_paths_absolute(whole);
  scenario.resolved_toml = print_toml(whole);
  return scenario;
}

}  // namespace internal

ReadResult read_scenario(const std::string& path, const ReadOptions& options) {
  using namespace internal;
  Errors errors;
  Value document = load_with_overrides(path, options, errors);
  if (errors.any()) return Failure(errors.sorted(path));
  ReadResult result = read_document(std::move(document), path, options.registry, options.real_time);
  if (result) result->notes = errors.notes();
  return result;
}

}  // namespace evenstep
