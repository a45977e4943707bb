// A study of the felt force as a table, as CSV and as JSON.
#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "evenstep/reports/felt_study_record.h"
#include "writers/texts/study_table.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

std::string force_text(double newtons) {
  if (newtons >= 1) return fmt::format("{:.3g} N", newtons);
  if (newtons >= 1e-3) return fmt::format("{:.3g} mN", newtons * 1e3);
  if (newtons > 0 && newtons < 1e-10) return "<0.1 nN";  // rounding
  return newtons >= 1e-6 ? fmt::format("{:.3g} uN", newtons * 1e6) : fmt::format("{:.3g} nN", newtons * 1e9);
}

std::string error_text(const FeltError& error) {
  return fmt::format("{} ({})", force_text(error.rms_N), force_text(error.max_N));
}

internal::StudyRow row_of(const FeltPoint& point, const std::vector<std::string>& machines) {
  internal::StudyRow row{point.strategy, "", fmt::format("{}, {}", point.method, point.solver),
                         internal::step_text(point.substep_s)};
  if (point.iterations > 0) row[2] += fmt::format(", {} it", point.iterations);
  if (point.state != StudyCell::State::measured) {
    row[4] = fmt::format("{}: {}", name_of(point.state), point.reason);
    return row;
  }
  row[1] = latency_text(point);
  row[4] = error_text(point.total) + (point.saturated > 0 ? " !" : "");
  row[5] = error_text(point.discretisation);
  row[6] = error_text(point.remap);
  row[7] = error_text(point.device);
  row[8] = internal::cost_text(point.cpu, machines, point.machine);
  return row;
}

std::string span_text(const FeltStudyRecord& study) {
  const std::string span = fmt::format("{:.6g} s to {:.6g} s", study.judged_from_s, study.judged_to_s);
  if (study.judged_to_s >= study.run_to_s) return span + ", all that the run judges";
  return span + fmt::format(", the first {:.6g} s of the {:.6g} s that the run judges ([study] duration)",
                            study.judged_to_s - study.judged_from_s, study.run_to_s - study.judged_from_s);
}

std::string reference_text(const FeltReferenceInfo& reference) {
  if (reference.method.empty()) return "none: it was interrupted";
  std::string out =
      reference.method_order > 0
          ? fmt::format("{}, cpu-double, steps of {} and its half and quarter, extrapolated by its order {}",
                        reference.method, internal::step_text(reference.coarsest_step_s), reference.method_order)
          : fmt::format("the scene itself every {}", internal::step_text(reference.coarsest_step_s));
  out += fmt::format("; its own error {} of {} rms", force_text(reference.estimate_N), force_text(reference.scale_N));
  if (reference.stored) return out + fmt::format("; stored, {:.3g} CPU s when it was computed", reference.cpu_s);
  return out + fmt::format("; {:.3g} CPU s{}", reference.cpu_s, reference.file.empty() ? "" : ", now stored");
}

Json json_of(const FeltError& error) { return {{"rms_N", json_number(error.rms_N)}, {"max_N", json_number(error.max_N)}}; }

Json json_of(const FeltPoint& point) {
  Json out = {{"strategy", point.strategy}, {"solver", point.solver}, {"method", point.method}};
  if (point.iterations > 0) out["iterations"] = point.iterations;
  out["substep_s"] = json_number(point.substep_s);
  out["substeps"] = point.substeps;
  out["state"] = name_of(point.state);
  if (point.state != StudyCell::State::measured) {
    out["reason"] = point.reason;
    return out;
  }
  out["latency_s"] = json_number(point.latency_s);
  out["device_latency_s"] = json_number(point.device_latency_s);
  out["total"] = json_of(point.total);
  out["discretisation"] = json_of(point.discretisation);
  out["remap"] = json_of(point.remap);
  out["device"] = json_of(point.device);
  out["saturated"] = point.saturated;
  out["cpu_s_per_s"] = internal::json_of(point.cpu);
  out["repeats"] = point.repeats;
  if (!point.machine.empty()) out["machine"] = point.machine;
  return out;
}

Json json_of(const FeltReferenceInfo& reference) {
  return {{"method", reference.method},
          {"method_order", reference.method_order},
          {"coarsest_step_s", json_number(reference.coarsest_step_s)},
          {"scale_N", json_number(reference.scale_N)},
          {"estimate_N", json_number(reference.estimate_N)},
          {"stored", reference.stored},
          {"file", reference.file},
          {"cpu_s", json_number(reference.cpu_s)}};
}

}  // namespace

std::string latency_text(const FeltPoint& point) {
  const auto ms = [](double seconds) { return std::round(seconds * 1e6) / 1e3 + 0.0; };  // + 0.0: no "-0"
  return fmt::format("{:.3f} + {:.3f} ms", ms(point.latency_s), ms(point.device_latency_s));
}

std::string felt_study_table(const FeltStudyRecord& study) {
  std::string out = fmt::format(
      "  machine      {}, load {:.2g}; {}\n"
      "  scene        {}\n"
      "  judged       {}: {} device ticks\n"
      "  reference    {}\n\n",
      internal::machine_text(study.machine, study.cpus), study.load, study.compiler, study.scene, span_text(study),
      study.ticks, reference_text(study.reference));
  std::vector<internal::StudyRow> rows{{"strategy", "latency", "method", "step", "felt error", "discretisation", "remap",
                                        "device", "CPU s per s (min .. max)"}};
  bool saturated = false;
  for (const FeltPoint& point : study.points) {
    rows.push_back(row_of(point, study.machines));
    saturated |= point.saturated > 0;
  }
  out += internal::aligned(rows);
  out +=
      "  errors: rms (greatest) over the ticks, each strategy against the force at its own latency; at every tick the felt\n"
      "  error is the sum of the three parts. latency: of the strategy + of the device, mean\n";
  if (saturated) out += "  ! some judged ticks met a limit of the device or its guard: that is in the device's part\n";
  if (const std::string warning = warning_of(study.machines); !warning.empty()) out += "  " + warning + '\n';
  if (study.interrupted) out += "  interrupted: points are missing\n";
  return out;
}

std::string felt_study_csv(const FeltStudyRecord& study) {
  std::string csv =
      "strategy,solver,method,iterations,substep_s,substeps,state,latency_s,device_latency_s,felt_rms_N,felt_max_N,"
      "discretisation_rms_N,discretisation_max_N,remap_rms_N,remap_max_N,device_rms_N,device_max_N,saturated,"
      "cpu_min_s_per_s,cpu_median_s_per_s,cpu_max_s_per_s,repeats,reason,machine\n";
  for (const FeltPoint& point : study.points) {
    fmt::format_to(std::back_inserter(csv), "{},{},{},{},{},{},{}", point.strategy, point.solver, point.method,
                   point.iterations > 0 ? fmt::format("{}", point.iterations) : "", point.substep_s, point.substeps,
                   name_of(point.state));
    if (point.state == StudyCell::State::measured) {
      fmt::format_to(std::back_inserter(csv), ",{},{}", point.latency_s, point.device_latency_s);
      for (const FeltError* error : {&point.total, &point.discretisation, &point.remap, &point.device})
        fmt::format_to(std::back_inserter(csv), ",{},{}", error->rms_N, error->max_N);
      fmt::format_to(std::back_inserter(csv), ",{},{},{},{},{},,{}\n", point.saturated, point.cpu.min, point.cpu.median,
                     point.cpu.max, point.repeats, internal::csv_field(point.machine));
    } else {
      csv += std::string(15, ',') + ',' + internal::csv_field(point.reason) + ",\n";
    }
  }
  return csv;
}

std::string felt_study_json(const FeltStudyRecord& study) {
  Json out = {{"format", 1},
              {"error", "felt-force"},
              {"evenstep", study.version},
              {"scenario", study.scenario},
              {"file", study.file},
              {"subject", fmt::format("{:016x}", study.subject)},
              {"seed", study.seed},
              {"machine", study.machine},
              {"cpus", study.cpus},
              {"load", json_number(study.load)},
              {"compiler", study.compiler},
              {"scene", study.scene},
              {"judged_from_s", json_number(study.judged_from_s)},
              {"judged_to_s", json_number(study.judged_to_s)},
              {"run_to_s", json_number(study.run_to_s)},
              {"step_s", json_number(study.step_s)},
              {"ticks", study.ticks},
              {"interrupted", study.interrupted},
              {"reference", json_of(study.reference)},
              {"points", Json::array()}};
  if (!study.machines.empty()) {
    out["machines"] = study.machines;
    out["warning"] = warning_of(study.machines);
  }
  for (const FeltPoint& point : study.points) out["points"].push_back(json_of(point));
  return json_text(out, "points") + '\n';
}

}  // namespace evenstep
