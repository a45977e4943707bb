// [scene]
#include <fmt/format.h>

#include "rational.h"
#include "sections.h"

namespace evenstep::internal {
namespace {

/// Only the top layer may be cut, and not all of it: otherwise a smaller lattice is meant.
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

TissueScene read_tissue(const Table& scene, Errors& errors) {
  TissueScene tissue;
  read_lattice(scene, tissue, errors);
  tissue.spacing_m = scene.si("spacing");
  tissue.particle_mass_kg = scene.si("mass");
  tissue.stiffness_N_per_m = scene.si("stiffness");
  tissue.damping_per_s = scene.si("damping") / tissue.particle_mass_kg;
  tissue.fixed.z_min = scene.text("fixed") == "bottom";
  const Value substeps = scene.at("substeps");
  tissue.substeps = substeps.is(Value::Kind::integer) ? static_cast<int>(substeps.integer) : 0;
  return tissue;
}

/// Every device of a tissue has a grab, and none of a spring.
void read_grabs(ScenarioReading& reading, TissueScene* tissue) {
  const Value* devices = reading.document.find("device");
  if (devices == nullptr || !reading.check.sound(devices)) return;
  for (const Value& value : devices->list) {
    const Table device(&value, "device", value.place);
    if (tissue == nullptr) {
      if (device.has("grab"))
        reading.errors.add(device.place("grab"),
                           "'grab' means nothing with a spring; remove it, or write kind = \"tissue\"");
      continue;
    }
    if (!device.has("grab")) {
      reading.errors.add(
          value.place,
          "[[device]] has no 'grab', which kind = \"tissue\" needs; write grab = { center = [\"65 mm\", \"65 mm\", "
          "\"135 mm\"], radius = \"6 mm\" }");
      continue;
    }
    const Table grab = device.table("grab");
    tissue->tools.push_back({grab.vector("center"), grab.si("radius")});
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
  reading.scenario.solver = solver == "opencl" ? SolverKind::opencl
                            : solver == "cpu"  ? SolverKind::cpu_float
                                               : SolverKind::cpu_double;
  scene.step_rate = read_step_rate(table, scene.step_rate);
  scene.tool_count = static_cast<int>(reading.scenario.devices.size());
  if (table.text("kind") == "spring") {
    scene.body = SpringScene{table.si("stiffness")};
    return read_grabs(reading, nullptr);
  }
  TissueScene tissue = read_tissue(table, reading.errors);
  read_grabs(reading, &tissue);
  scene.body = std::move(tissue);
  scene.allow_unstable = table.boolean("allow_unstable");
  reading.scenario.work_group_size = static_cast<int>(table.integer("work_group_size"));
}

}  // namespace evenstep::internal
