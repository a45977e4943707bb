// [scene]
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "evenstep/format/load.h"
#include "evenstep/plugins/process_solver.h"
#include "evenstep/text/rational.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

/// Checks that only the top layer is cut, and not all of it; otherwise a smaller lattice would have been meant.
void read_lattice(const Table& scene, TissueScene& tissue, Errors& errors) {
  const Value lattice = scene.at("lattice");
  std::int64_t sites = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    tissue.lattice[axis] = static_cast<int>(lattice.list[axis].integer);
    sites *= tissue.lattice[axis];  // at most 1e12
  }
  tissue.particle_count = scene.has("particles") ? scene.integer("particles") : sites;
  const std::int64_t layer = std::int64_t{tissue.lattice[0]} * tissue.lattice[1];
  constexpr std::int64_t kMostParticles = 100'000'000;
  if (tissue.particle_count > sites) {
    errors.add(scene.place("particles"),
               fmt::format("'particles': {} do not fit the {} sites of the lattice; write at most {}, or a larger lattice",
                           tissue.particle_count, sites, sites));
  } else if (tissue.particle_count <= sites - layer) {
    errors.add(scene.place("particles"),
               fmt::format("'particles': {} of {} sites would cut more than the top layer of {}; write a smaller lattice",
                           tissue.particle_count, sites, layer));
  } else if (tissue.particle_count > kMostParticles) {
    errors.add(scene.place("lattice"),
               fmt::format("'lattice': {} particles are more than the limit of {}", tissue.particle_count, kMostParticles));
  }
}

FixedFaces read_fixed(const Table& scene, Errors& errors) {
  const Value fixed = scene.at("fixed");
  const std::vector<Value> faces = fixed.is(Value::Kind::list) ? fixed.list : std::vector<Value>{fixed};
  FixedFaces out = FixedFaces::none();
  const std::array<std::pair<const char*, bool*>, 6> named{{{"left", &out.x_min},
                                                            {"right", &out.x_max},
                                                            {"front", &out.y_min},
                                                            {"back", &out.y_max},
                                                            {"bottom", &out.z_min},
                                                            {"top", &out.z_max}}};
  for (const Value& face : faces) {
    if (face.text == "none" && faces.size() > 1)
      errors.add(face.place, "'fixed': \"none\" stands among faces; write \"none\" alone, or the faces alone");
    for (const auto& [name, is_fixed] : named) {
      if (face.text != name) continue;
      if (*is_fixed) errors.add(face.place, fmt::format("'fixed' names \"{}\" twice", name));
      *is_fixed = true;
    }
  }
  return out;
}

/// Whether a site of the lattice lies between these two, along one axis (as sim/src/tissue/materials.cpp counts).
bool holds_a_site(int sites, double spacing_m, double min_m, double max_m) {
  for (int n = 0; n < sites; ++n) {
    if (n * spacing_m >= min_m && n * spacing_m <= max_m) return true;
  }
  return false;
}

MaterialRegion read_region(const Table& table, const TissueScene& tissue, Errors& errors) {
  MaterialRegion region{table.vector("min"), table.vector("max"), tissue.stiffness_N_per_m, tissue.particle_mass_kg};
  if (table.has("stiffness")) region.stiffness_N_per_m = table.si("stiffness");
  if (table.has("mass")) region.particle_mass_kg = table.si("mass");
  if (!table.has("stiffness") && !table.has("mass"))
    errors.add(table.place("min"), "a region without 'stiffness' and 'mass' is no other material; write one of them");
  for (int axis = 0; axis < 3; ++axis) {
    const char name = "xyz"[axis];
    if (region.min_m[axis] > region.max_m[axis]) {
      errors.add(table.place("max"), fmt::format("'max': {:g} mm along {} is below min, {:g} mm; exchange them",
                                                 region.max_m[axis] * 1e3, name, region.min_m[axis] * 1e3));
    } else if (const int sites = tissue.lattice[static_cast<std::size_t>(axis)];
               !holds_a_site(sites, tissue.spacing_m, region.min_m[axis], region.max_m[axis])) {
      errors.add(table.place("min"),
                 fmt::format("'regions': no particle is inside: along {} they stand at 0 mm to {:g} mm, {:g} mm apart", name,
                             (sites - 1) * tissue.spacing_m * 1e3, tissue.spacing_m * 1e3));
    }
  }
  return region;
}

void read_regions(const Table& scene, TissueScene& tissue, Errors& errors) {
  const std::vector<Table> regions = scene.tables("regions");
  if (regions.size() > static_cast<std::size_t>(kMaxRegions)) {
    errors.add(scene.place("regions"),
               fmt::format("'regions' lists {} boxes; there can be {} materials besides the block's own", regions.size(),
                           kMaxRegions));
    return;
  }
  for (const Table& region : regions) tissue.regions.push_back(read_region(region, tissue, errors));
}

void read_method(const Table& scene, TissueScene& tissue, Errors& errors) {
  const std::string name = scene.text("method");
  tissue.method = *std::find_if(kAllMethods.begin(), kAllMethods.end(), [&](Method m) { return name == name_of(m); });
  if (!scene.has("iterations")) return;
  tissue.iterations = static_cast<int>(scene.integer("iterations"));
  if (iterates(tissue.method)) return;
  errors.add(
      scene.place("iterations"),
      fmt::format("'iterations' means nothing with method = \"{}\"; remove it, or write method = \"implicit-euler\" or "
                  "\"implicit-midpoint\" or \"vertex-block-descent\"",
                  name));
}

TissueScene read_tissue(const Table& scene, Errors& errors) {
  TissueScene tissue;
  read_lattice(scene, tissue, errors);
  tissue.spacing_m = scene.si("spacing");
  tissue.particle_mass_kg = scene.si("mass");
  tissue.stiffness_N_per_m = scene.si("stiffness");
  tissue.damping_per_s = scene.si("damping") / tissue.particle_mass_kg;
  tissue.axial_damping_N_s_per_m = scene.si("axial_damping");
  tissue.gravity_m_per_s2 = scene.vector("gravity");
  tissue.fixed = read_fixed(scene, errors);
  read_regions(scene, tissue, errors);
  read_method(scene, tissue, errors);
  const Value substeps = scene.at("substeps");
  tissue.substeps = substeps.is(Value::Kind::integer) ? static_cast<int>(substeps.integer) : 0;
  return tissue;
}

ToolCoupling read_coupling(const Table& grab) {
  ToolCoupling tool{grab.vector("center"), grab.si("radius")};
  const std::string coupling = grab.text("coupling");
  if (coupling == "grab") return tool;
  tool.kind = coupling == "spring" ? CouplingKind::spring : CouplingKind::probe;
  tool.stiffness_N_per_m = grab.si("stiffness");
  if (tool.kind == CouplingKind::spring) tool.damping_N_s_per_m = grab.si("damping");
  return tool;
}

/// Reads where a surface lies. The length of its normal does not matter, but must not be 0.
template <class Body>
void read_surface(const Table& scene, Body& body, Errors& errors) {
  const Value normal = scene.at("normal");
  for (int axis = 0; axis < 3; ++axis) {
    const Value& part = normal.list[static_cast<std::size_t>(axis)];
    body.normal[axis] = part.is(Value::Kind::integer) ? static_cast<double>(part.integer) : part.number;
  }
  if (body.normal == glm::dvec3(0))
    errors.add(scene.place("normal"), "'normal': [0, 0, 0] points nowhere; write [1, 0, 0], out of the surface");
  body.surface_m = scene.si("surface");
}

WallScene read_wall(const Table& scene, Errors& errors) {
  WallScene wall;
  wall.stiffness_N_per_m = scene.si("stiffness");
  read_surface(scene, wall, errors);
  if (scene.has("hardening")) wall.hardening_m = scene.si("hardening");
  return wall;
}

ModeScene read_mode(const Table& scene, Errors& errors) {
  ModeScene mode;
  mode.stiffness_N_per_m = scene.si("stiffness");
  mode.frequency_Hz = in_Hz(scene.rate("frequency"));
  mode.damping_ratio = scene.number("damping_ratio");
  mode.one_sided = scene.boolean("one_sided");
  read_surface(scene, mode, errors);
  for (const char* key : {"normal", "surface"}) {
    if (!mode.one_sided && scene.has(key))
      errors.add(scene.place(key), fmt::format("'{}' means nothing where the mode pulls as it pushes; remove it, or write "
                                               "one_sided = true",
                                               key));
  }
  return mode;
}

/// A solver that is a process: only whether its program is there can be said before it runs.
void read_command(const ScenarioReading& reading, const Table& table, ForeignScene& scene) {
  const Value command = table.at("command");
  ProcessCommand process;
  for (const Value& word : command.list) process.words.push_back(word.text);
  process.folder = path_from(table.has("directory") ? table.at("directory") : text_value(".", command.place));
  process.answer_limit = table.duration("answer_within");
  if (process.words.empty() || process.words.front().empty())
    return reading.errors.add(command.place, "'command' names no program; write command = [\"python3\", \"mine.py\"]");
  std::error_code ignored;
  if (!std::filesystem::is_directory(process.folder, ignored))
    return reading.errors.add(table.place("directory"), fmt::format("'directory': there is no folder '{}'", process.folder));
  if (!program_of(process))
    return reading.errors.add(command.list.front().place,
                              fmt::format("'command': there is no program '{}' that can be run; {}", process.words.front(),
                                          process.words.front().find('/') == std::string::npos
                                              ? "it was looked for in PATH; \"./mine\" is one in the scenario's folder"
                                              : fmt::format("its path is counted from '{}'", process.folder)));
  scene.make = process_solver(process);
  scene.name = text_of(process);
  scene.origin = "a process";
}

ForeignScene read_foreign_scene(ScenarioReading& reading, const Table& table) {
  ForeignScene scene;
  Foreign part = read_foreign(reading, table, !table.has("command"));
  reading.scenario.scene_place = part.place;
  scene.options = part.options;
  scene.seed = part.seed;
  for (const char* key : {"directory", "answer_within"}) {
    if (table.has(key) && !table.has("command"))
      reading.errors.add(table.place(key), fmt::format("'{}' is about a 'command', and there is none; remove it", key));
  }
  if (table.has("command")) {
    reading.scenario.scene_place = table.place("command");
    for (const char* other : {"name", "library"}) {
      if (table.has(other))
        reading.errors.add(table.place(other), fmt::format("'{}' does not go with 'command'; remove one of them", other));
    }
    read_command(reading, table, scene);
    return scene;
  }
  scene.make = maker_of("solver", part, reading.registry.solvers(), &Library::solver, reading.errors);
  scene.name = part.name;
  if (!part.library.empty()) scene.origin = fmt::format("the solver in {}", part.library);
  return scene;
}

/// Reads the grabs. With a tissue every device must have one; with other scenes none may have one.
void read_grabs(ScenarioReading& reading, TissueScene* tissue) {
  const Value* devices = reading.document.find("device");
  if (devices == nullptr || !reading.check.sound(devices)) return;
  for (const Value& value : devices->list) {
    const Table device(&value, "device", value.place);
    if (tissue == nullptr) {
      if (device.has("grab"))
        reading.errors.add(device.place("grab"),
                           "'grab' means nothing without a tissue; remove it, or write kind = \"tissue\"");
      continue;
    }
    if (!device.has("grab")) {
      reading.errors.add(
          value.place,
          "[[device]] has no 'grab', which kind = \"tissue\" needs; write grab = { center = [\"65 mm\", \"65 mm\", "
          "\"135 mm\"], radius = \"6 mm\" }");
      continue;
    }
    tissue->tools.push_back(read_coupling(device.table("grab")));
  }
}

}  // namespace

Rate read_step_rate(const Table& scene, Rate filled) {
  const std::string text = scene.text("step_size");
  if (text == "fill") return filled;
  const Result<Rate> rate = parse_rate(text);
  return rate ? *rate : reduced_rate(1'000'000'000, parse_duration(text)->ns);
}

void read_scene(ScenarioReading& reading) {
  if (!reading.sound("scene") || reading.document.find("scene") == nullptr) return;
  const Table table = reading.section("scene");
  Scene& scene = reading.scenario.scene;
  const std::string solver = table.text("solver");
  reading.scenario.solver =
      *std::find_if(kAllSolvers.begin(), kAllSolvers.end(), [&](SolverKind kind) { return solver == name_of(kind); });
  reading.scenario.solver_place = table.place("solver");
  reading.scenario.scene_place = table.place("kind");
  scene.step_rate = read_step_rate(table, scene.step_rate);
  // `ideal` makes a step in every slot.
  const double slots = seconds(reading.scenario.run_duration) * static_cast<double>(scene.step_rate.num) /
                       static_cast<double>(scene.step_rate.den);
  if (table.text("step_size") != "fill" && slots > static_cast<double>(kMostRunSteps))
    reading.errors.add(table.place("step_size"),
                       fmt::format("'step_size': {:.3g} steps of this size make up the run, and it has at most {}; write a "
                                   "larger one, or run for a shorter time",
                                   slots, kMostRunSteps));
  scene.tool_count = static_cast<int>(reading.scenario.devices.size());
  const std::string kind = table.has("kind") ? table.text("kind") : "foreign";
  if (kind != "tissue") {
    if (kind == "spring") scene.body = SpringScene{table.si("stiffness")};
    if (kind == "wall") scene.body = read_wall(table, reading.errors);
    if (kind == "mode") scene.body = read_mode(table, reading.errors);
    if (kind == "foreign") scene.body = read_foreign_scene(reading, table);
    return read_grabs(reading, nullptr);
  }
  TissueScene tissue = read_tissue(table, reading.errors);
  read_grabs(reading, &tissue);
  scene.body = std::move(tissue);
  scene.allow_unstable = table.boolean("allow_unstable");
  const std::string local_model = table.text("local_model");
  scene.local_model = local_model == "settled"         ? LocalModel::settled
                      : local_model == "instantaneous" ? LocalModel::instantaneous
                                                       : LocalModel::none;
  reading.scenario.solver_options.work_group_size = static_cast<int>(table.integer("work_group_size"));
  if (table.has("opencl_device")) reading.scenario.solver_options.opencl_device = table.text("opencl_device");
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& scene_fields() {
  static const std::vector<Field> rows{
      {.table = "scene", .key = "kind", .forms = kWord,
       .meaning =
           "`spring`: F = -k x, memoryless. `wall`: pushes out what is behind its surface. `mode`: a mass between two "
           "springs, which rings. `tissue`: particles on a lattice, each joined to its 18 neighbours by springs. `foreign`: "
           "a solver of your own; need not be written where `library` or `command` is.",
       .words = "spring|wall|mode|tissue|foreign", .required = true, .example = "\"spring\""},
      {.table = "scene", .key = "solver", .forms = kWord, .default_toml = "\"cpu-double\"",
       .meaning = "What computes it.",
       .words = "opencl|cpu|cpu-double", .kinds = "spring"},
      {.table = "scene", .key = "solver", .forms = kWord, .default_toml = "\"opencl\"",
       .meaning = "What computes it; `cpu` (float) and `opencl` agree bit for bit.",
       .words = "opencl|cpu|cpu-double", .kinds = "tissue"},
      {.table = "scene", .key = "stiffness", .forms = kQuantity, .default_toml = "\"200 N/m\"",
       .meaning = "k. For a `mode` it is the stiffness at rest; at first the tool feels twice that.",
       .kinds = "spring|wall|mode", .dimension = D::stiffness, .range = at_least(0)},
      {.table = "scene", .key = "stiffness", .forms = kQuantity, .default_toml = "\"50 N/m\"",
       .meaning = "k of each spring.",
       .kinds = "tissue", .dimension = D::stiffness, .range = above(0)},
      {.table = "scene", .key = "normal", .forms = kNumber, .shape = Shape::three, .default_toml = "[1, 0, 0]",
       .meaning = "Out of the surface, towards the tool; of any length.",
       .kinds = "wall|mode"},
      {.table = "scene", .key = "surface", .forms = kQuantity, .default_toml = "\"0 mm\"",
       .meaning = "Where the surface is along the normal, counted from the origin.",
       .kinds = "wall|mode", .dimension = D::length},
      {.table = "scene", .key = "hardening", .forms = kQuantity,
       .meaning = "F = k (p + p^2 / hardening) at the depth p. Default: F = k p.",
       .kinds = "wall", .dimension = D::length, .range = above(0), .example = "\"5 mm\""},
      {.table = "scene", .key = "frequency", .forms = kRate,
       .meaning = "Frequency of the mass between its springs while the tool is held still.",
       .kinds = "mode", .required = true, .range = between(0.01, 1000), .example = "\"30 Hz\""},
      {.table = "scene", .key = "damping_ratio", .forms = kNumber, .default_toml = "0.1",
       .meaning = "Damping ratio of that mass; 1 is critical.",
       .kinds = "mode", .range = between(0, 10)},
      {.table = "scene", .key = "one_sided", .forms = kBoolean, .default_toml = "false",
       .meaning =
           "It pushes along its normal and never pulls. Otherwise it pushes and pulls along every axis, from the origin.",
       .kinds = "mode"},
      {.table = "scene", .key = "step_size", .forms = kWord | kDuration | kRate, .default_toml = "\"fill\"",
       .meaning = "Simulation time per step, or steps per simulated second. `fill`: segment / mean N, so that simulated "
                  "time keeps pace with real time (a trace: its length / its steps).",
       .words = "fill", .range = above(0)},
      {.table = "scene", .key = "lattice", .forms = kInteger, .shape = Shape::three, .default_toml = "[27, 27, 28]",
       .meaning = "Particles along x, y, z.",
       .kinds = "tissue", .range = between(1, 10'000)},
      {.table = "scene", .key = "particles", .forms = kInteger,
       .meaning =
           "Number of particles; the lattice is cut to it by leaving out the last sites of its top layer. Default: all.",
       .kinds = "tissue", .range = between(1, kMostParticles), .example = "20270"},
      {.table = "scene", .key = "spacing", .forms = kQuantity, .default_toml = "\"5 mm\"",
       .meaning = "Between neighbours.",
       .kinds = "tissue", .dimension = D::length, .range = above(0, 1)},
      {.table = "scene", .key = "mass", .forms = kQuantity, .default_toml = "\"0.125 g\"",
       .meaning = "Mass of one particle.",
       .kinds = "tissue", .dimension = D::mass, .range = above(0)},
      {.table = "scene", .key = "damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
       .meaning = "Drag on one particle: a force of damping * velocity against its motion.",
       .kinds = "tissue", .dimension = D::damping, .range = at_least(0)},
      {.table = "scene", .key = "axial_damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
       .meaning = "Damper along every spring: a force of axial_damping * the velocity at which its ends part.",
       .kinds = "tissue", .dimension = D::damping, .range = at_least(0)},
      {.table = "scene", .key = "gravity", .forms = kQuantity, .shape = Shape::three,
       .default_toml = "[\"0 m/s2\", \"0 m/s2\", \"0 m/s2\"]",
       .meaning = "On every particle.",
       .kinds = "tissue", .dimension = D::acceleration, .example = "[\"0 m/s2\", \"0 m/s2\", \"-9.81 m/s2\"]"},
      {.table = "scene", .key = "fixed", .forms = kWord, .shape = Shape::one_or_list, .default_toml = "\"bottom\"",
       .meaning = "Faces of the lattice whose particles never move: `left` and `right` (least and greatest x), `front` and "
                  "`back` (y), `bottom` and `top` (z).",
       .words = "left|right|front|back|bottom|top|none", .kinds = "tissue"},
      {.table = "scene", .key = "regions", .forms = kTable, .shape = Shape::list, .default_toml = "[]",
       .meaning = "Boxes of another material; if two contain the same particle, the later one counts. A spring between two "
                  "materials has the mean of their stiffnesses. At most 60.",
       .kinds = "tissue"},
      {.table = "scene", .key = "method", .forms = kWord, .default_toml = "\"symplectic-euler\"",
       .meaning =
           "How the equations of motion are integrated. The last three are implicit: stable at any step, and each step "
           "costs its iterations.",
       .words = method_words(), .kinds = "tissue"},
      {.table = "scene", .key = "iterations", .forms = kInteger,
       .meaning =
           "Of an implicit method's solver, per substep: of conjugate gradients, or sweeps of `vertex-block-descent`. "
           "Default: the method's own.",
       .kinds = "tissue", .range = between(1, kMostIterations), .example = "10"},
      {.table = "scene", .key = "local_model", .forms = kWord, .default_toml = "\"none\"",
       .meaning =
           "Stiffness at the tool that the solver reports with each force. `instantaneous`: the other particles stay; "
           "`settled`: they come to rest again (measured at rest when the scene loads).",
       .words = "none|instantaneous|settled", .kinds = "tissue"},
      {.table = "scene", .key = "substeps", .forms = kWord | kInteger, .default_toml = "\"auto\"",
       .meaning = "Solver steps per step. `auto`: the fewest that are stable in every configuration.",
       .words = "auto", .kinds = "tissue", .range = between(1, kMostSubsteps)},
      {.table = "scene", .key = "allow_unstable", .forms = kBoolean, .default_toml = "false",
       .meaning = "Lets an unstable step size start.",
       .kinds = "tissue"},
      {.table = "scene", .key = "work_group_size", .forms = kInteger, .default_toml = "64",
       .meaning = "OpenCL work items per group; results do not depend on it.",
       .kinds = "tissue", .range = between(1, 4096)},
      {.table = "scene", .key = "opencl_device", .forms = kText,
       .meaning = "A part of the name of the OpenCL device, or of its platform; results do not depend on it. Default: PoCL "
                  "where it is installed (`record`: a GPU where there is one). `evenstep devices --opencl` lists them.",
       .kinds = "tissue", .example = "\"NVIDIA\""},
      {.table = "scene.regions", .key = "min", .forms = kQuantity, .shape = Shape::three,
       .meaning = "Corner of the box, in the block's coordinates at rest: the origin is the block's minimum corner.",
       .required = true, .dimension = D::length, .example = "[\"0 mm\", \"0 mm\", \"0 mm\"]"},
      {.table = "scene.regions", .key = "max", .forms = kQuantity, .shape = Shape::three,
       .meaning = "Opposite corner; particles on the faces are inside.",
       .required = true, .dimension = D::length, .example = "[\"10 mm\", \"10 mm\", \"10 mm\"]"},
      {.table = "scene.regions", .key = "stiffness", .forms = kQuantity,
       .meaning = "k of each spring. Default: as outside.",
       .dimension = D::stiffness, .range = above(0)},
      {.table = "scene.regions", .key = "mass", .forms = kQuantity,
       .meaning = "Mass of one particle. Default: as outside the region.",
       .dimension = D::mass, .range = above(0)},
  };
  static const std::vector<Field> command{
      {.table = "scene", .key = "command", .forms = kText, .shape = Shape::list,
       .meaning = "A solver that is a program of its own, and its arguments (docs/parts/process-protocol.md); no shell is "
                  "used. Write this instead of `name` or `library`.",
       .kinds = "foreign", .example = "[\"python3\", \"mine.py\"]"},
      {.table = "scene", .key = "directory", .forms = kFile,
       .meaning = "The working directory of `command`. Default: the folder of the file that names it.",
       .kinds = "foreign"},
      {.table = "scene", .key = "answer_within", .forms = kDuration, .default_toml = "\"30 s\"",
       .meaning = "How long `command` may take for one answer, in real time; a step that takes longer ends the run.",
       .kinds = "foreign", .range = between(0.001, 86400)},
  };
  static const std::vector<Field> all = joined(joined(rows, foreign_rows("scene", "foreign")), command);
  return all;
}
// clang-format on

}  // namespace evenstep::internal
