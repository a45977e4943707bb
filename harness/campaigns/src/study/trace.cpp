#include "trace.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "evenstep/text/rational.h"
#include "foreign_substeps.h"

namespace evenstep::internal {
namespace {

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
double square(const glm::dvec3& v) { return v.x * v.x + v.y * v.y + v.z * v.z; }

RealTime begin_of(const Scenario& scenario) {
  RealTime begin = kNever;
  for (const DeviceSpec& device : scenario.devices) begin = std::min(begin, device.motion.begin);
  return begin;
}

/// The tools after `n` steps of the scene along the motion.
class Tools {
 public:
  explicit Tools(const Scenario& scenario) : scenario_(scenario), begin_(begin_of(scenario)) {}
  std::span<const glm::dvec3> at(std::int64_t n) {
    const RealTime at{begin_.ns + instant_ns(scenario_.scene.step_rate, n)};
    for (std::size_t tool = 0; tool < scenario_.devices.size(); ++tool)
      positions_m_[tool] = position_m(scenario_.devices[tool].motion, at);
    return {positions_m_.data(), scenario_.devices.size()};
  }

 private:
  const Scenario& scenario_;
  RealTime begin_;
  std::array<glm::dvec3, kMaxTools> positions_m_{};
};

/// Calls each(n, response) after every step of the solver along the motion, when n steps of the scene are done; false ends
/// it. Throws StudyInterrupted.
template <class Each>
void run_through(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step,
                 const std::atomic<bool>* interrupted, Each each) {
  Tools tools(scenario);
  const auto step_at = [&](std::int64_t n) {
    if (interrupted && *interrupted) throw StudyInterrupted{};
    return solver.step(tools.at(n));
  };
  for (std::int64_t n = 0; n < plan.rest; n += step.steps) step_at(0);
  for (std::int64_t n = step.steps; n <= plan.samples * plan.stride; n += step.steps) {
    if (!each(n, step_at(n))) return;
  }
}

}  // namespace

StudyPlan::StudyPlan(const Scenario& scenario, const std::vector<StudyStep>& steps) {
  for (const StudyStep& step : steps) rest = std::lcm(rest, static_cast<std::int64_t>(step.steps));
  const Rate rate = scenario.scene.step_rate;
  const std::int64_t count = floor_mul_div(scenario.study.duration.ns, rate.num, rate.den * 1'000'000'000);
  const std::int64_t most = rest * kMostStudySamples;
  stride = rest * std::max<std::int64_t>(1, (count + most - 1) / most);
  samples = count / stride;
}

double StudyPlan::rest_s(const Scenario& scenario) const {
  return static_cast<double>(rest) * period_s(scenario.scene.step_rate);
}
double StudyPlan::duration_s(const Scenario& scenario) const {
  return static_cast<double>(samples * stride) * period_s(scenario.scene.step_rate);
}

std::unique_ptr<Solver> make_study_solver(const Scenario& scenario, const StudyRun& run, bool measured) {
  Scene scene = scenario.scene;
  if (auto* tissue = std::get_if<TissueScene>(&scene.body)) {
    tissue->method = run.method;
    tissue->iterations = run.iterations;
    tissue->substeps = run.step.substeps;
  } else if (const auto* foreign = std::get_if<ForeignScene>(&scene.body)) {
    scene.body = with_substeps(*foreign, run.step.substeps);
  }
  scene.step_rate = reduced_rate(scene.step_rate.num, static_cast<__int128>(scene.step_rate.den) * run.step.steps);
  scene.needs_energy = measured;
  scene.needs_state_digest = false;
  scene.variable_step = false;
  scene.local_model = LocalModel::none;
  return make_solver(run.solver, scene, scenario.solver_options);
}

StudyTrace trace_of(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step,
                    const std::atomic<bool>* interrupted) {
  StudyTrace trace;
  run_through(solver, scenario, plan, step, interrupted, [&](std::int64_t n, const ToolResponse& response) {
    if (n % plan.stride != 0) return true;
    ParticleState state = solver.particle_state();
    const double energy_J = solver.verdict().energy_J;
    const bool ok = std::isfinite(energy_J) && std::all_of(response.force_N.begin(), response.force_N.end(), finite) &&
                    std::all_of(state.displacement_m.begin(), state.displacement_m.end(), finite);
    if (!ok) {
      trace.first_bad_sample = n / plan.stride;
      return false;
    }
    trace.displacement_m.push_back(std::move(state.displacement_m));
    trace.force_N.push_back(response.force_N);
    trace.energy_J.push_back(energy_J);
    return true;
  });
  return trace;
}

void step_through(Solver& solver, const Scenario& scenario, const StudyPlan& plan, StudyStep step,
                  const std::atomic<bool>* interrupted) {
  run_through(solver, scenario, plan, step, interrupted, [](std::int64_t, const ToolResponse&) { return true; });
}

StudyValues rms(const StudyTrace& a, const StudyTrace* b) {
  double position = 0, force = 0, energy = 0;
  for (std::size_t s = 0; s < a.energy_J.size(); ++s) {
    for (std::size_t p = 0; p < a.displacement_m[s].size(); ++p)
      position += square(a.displacement_m[s][p] - (b ? b->displacement_m[s][p] : glm::dvec3(0)));
    for (std::size_t tool = 0; tool < a.force_N[s].size(); ++tool)
      force += square(a.force_N[s][tool] - (b ? b->force_N[s][tool] : glm::dvec3(0)));
    const double difference_J = a.energy_J[s] - (b ? b->energy_J[s] : 0);
    energy += difference_J * difference_J;
  }
  const auto samples = static_cast<double>(a.energy_J.size());
  StudyValues values;
  values[StudyQuantity::position] = std::sqrt(position / samples / static_cast<double>(a.displacement_m[0].size()));
  values[StudyQuantity::force] = std::sqrt(force / samples);
  values[StudyQuantity::energy] = std::sqrt(energy / samples);
  return values;
}

StudyValues error_of(const StudyTrace& a, const StudyTrace& reference, const StudyValues& scale) {
  StudyValues error = rms(a, &reference);
  for (const StudyQuantity q : {StudyQuantity::force, StudyQuantity::energy})
    error[q] = scale[q] > 0 ? error[q] / scale[q] : NAN;
  return error;
}

}  // namespace evenstep::internal
