// [scene]
#include <fmt/format.h>

#include <algorithm>

#include "evenstep/text/rational.h"
#include "sections.h"

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

/// Whether a site of the lattice lies between these two, along one axis (as sim/src/materials.cpp counts).
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
                                               "one_sided = true", key));
  }
  return mode;
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

Rate read_step_rate(const Table& scene, Rate filled) {
  const std::string text = scene.text("step_size");
  if (text == "fill") return filled;
  const Parsed<Rate> rate = parse_rate(text);
  return rate.ok() ? rate.value : reduced_rate(1'000'000'000, parse_duration(text).value.ns);
}

}  // namespace

void read_scene(ScenarioReading& reading) {
  if (!reading.sound("scene") || reading.document.find("scene") == nullptr) return;
  const Table table = reading.section("scene");
  Scene& scene = reading.scenario.scene;
  const std::string solver = table.text("solver");
  reading.scenario.solver =
      *std::find_if(kAllSolvers.begin(), kAllSolvers.end(), [&](SolverKind kind) { return solver == name_of(kind); });
  scene.step_rate = read_step_rate(table, scene.step_rate);
  scene.tool_count = static_cast<int>(reading.scenario.devices.size());
  const std::string kind = table.text("kind");
  if (kind != "tissue") {
    if (kind == "spring") scene.body = SpringScene{table.si("stiffness")};
    if (kind == "wall") scene.body = read_wall(table, reading.errors);
    if (kind == "mode") scene.body = read_mode(table, reading.errors);
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
  reading.scenario.work_group_size = static_cast<int>(table.integer("work_group_size"));
}

}  // namespace evenstep::internal
