#pragma once
/// Error against cost of the force that the hand feels: every strategy with every method and step, against the force that
/// the scene gives for the hand's motion without delay, at the accuracy of the reference. The record is filled in by
/// evenstep/campaigns/felt_study.h; the writers here turn it into text.
///
/// At the judged tick k of a device, at the time t, and with the mean age a of what the force of a tick answers,
///   e(k) = felt(k) - f*(t - a)
/// is split along a chain of runs; each is compared with f* at its own mean age, so that latency alone is no error:
///  A  f*, the reference
///  B  the same method and step, on even steps that read the motion itself     discretisation d(k) = B(t - a) - f*(t - a)
///  C  the strategy in the timing of the scenario, with an ideal device        remap          r(k) = C(k) - f*(t - a) - d(k)
///  D  the strategy with the scenario's device: felt(k) is what its motors do  device         v(k) = e(k) - d(k) - r(k)
/// So e = d + r + v at every tick. Squares of rms values do not add up exactly, because the parts are correlated. a is that
/// of C in d and r, and that of D in e.

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "evenstep/reports/study_record.h"

namespace evenstep {

/// Over the judged ticks of all devices; of the length of the difference of two forces, N.
struct FeltError {
  double rms_N = NAN, max_N = NAN;
};

struct FeltPoint {
  std::string strategy;
  /// method "none": the scene has no motion to integrate; "own": that of a solver of the program
  std::string solver, method;
  int iterations = 0;    ///< per substep, for methods that iterate; otherwise 0
  double substep_s = 0;  ///< the step of the method
  int substeps = 1;      ///< per step of the scene
  StudyCell::State state = StudyCell::State::measured;
  std::string reason;  ///< for every state except `measured`
  FeltError total, discretisation, remap, device;
  double latency_s = 0;         ///< mean age of what a force answers, with an ideal device; the greatest of the devices
  double device_latency_s = 0;  ///< what the scenario's device adds to it
  std::int64_t saturated = 0;   ///< judged ticks at which force or position met a limit
  StudyCost cpu;  ///< CPU seconds of the solver per simulated second; strategies of one method and step share it
  int repeats = 0;
  std::string machine;  ///< on which it was measured, if the points of the study come from several
};

struct FeltReferenceInfo {
  std::string method;          ///< "rk4"; "none": the scene has no motion to integrate; empty: interrupted
  int method_order = 0;        ///< on which the extrapolation relies; 0: none needed, or none known (foreign solver)
  double coarsest_step_s = 0;  ///< of three runs, each with half the step of the one before; tools move at its multiples
  double scale_N = 0;          ///< rms of the force over judged ticks of all devices
  double estimate_N = NAN;     ///< its own error, at most
  bool stored = false;         ///< read from a file of an earlier study
  std::string file;            ///< where it is kept; empty: nowhere
  double cpu_s = 0;            ///< CPU time that it took, or took when it was computed
};

struct FeltStudyRecord {
  std::string scenario, file, version;
  std::string machine, compiler;
  std::int64_t cpus = 0;              ///< 0: of several machines
  std::vector<std::string> machines;  ///< of the costs, if these come from several; otherwise empty
  double load = 0;                    ///< of the machine when the study began: runnable processes, mean over a minute
  std::uint64_t seed = 1;
  std::string scene;                                        ///< in one line
  double judged_from_s = 0, judged_to_s = 0, run_to_s = 0;  ///< what is judged, and where the run itself ends
  double step_s = 0;                                        ///< step of the scene
  std::int64_t ticks = 0;                                   ///< judged, of all devices
  std::uint64_t subject = 0;  ///< digest of everything that the run depends on, to find out whose study this is
  FeltReferenceInfo reference;
  std::vector<FeltPoint> points;  ///< by strategy, then solver, method, iterations and step
  bool interrupted = false;       ///< points are missing
};

/// "15.064 + 0.250 ms": that of the strategy, and what the device adds.
std::string latency_text(const FeltPoint& point);
std::string felt_study_table(const FeltStudyRecord& study);
/// One row per point; the fields of a point that was not measured are empty.
std::string felt_study_csv(const FeltStudyRecord& study);
std::string felt_study_json(const FeltStudyRecord& study);
/// The error (y) against CPU seconds per simulated second (x), a line for each strategy and method; and, for each point,
/// its parts.
std::string felt_study_svg(const FeltStudyRecord& study);

}  // namespace evenstep
