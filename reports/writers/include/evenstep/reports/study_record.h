#pragma once
/// Error against run time (work-precision): what every solver, method and step of a study costs, and how large its error is.
/// The record is filled in by evenstep/campaigns/study.h; the writers here turn it into text. Definitions:
/// docs/forces/study.md.

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace evenstep {

/// The quantity whose error is measured; a is the cell and r the reference at the common sample times:
///   position  rms over particles and samples of |a - r|, m
///   force     rms over samples and tools of |a - r| over the rms of |r|
///   energy    rms over samples of a - r over the rms of r
enum class StudyQuantity : std::uint8_t { position, force, energy };
inline constexpr std::array kStudyQuantities{StudyQuantity::position, StudyQuantity::force, StudyQuantity::energy};
const char* name_of(StudyQuantity quantity);

/// One number per quantity; NaN if there is none (nothing to be relative to, or no other step to compare with).
class StudyValues {
 public:
  double& operator[](StudyQuantity q) { return values_[static_cast<std::size_t>(q)]; }
  double operator[](StudyQuantity q) const { return values_[static_cast<std::size_t>(q)]; }

 private:
  std::array<double, kStudyQuantities.size()> values_{NAN, NAN, NAN};
};

/// Seconds per simulated second; minimum, median and maximum over the repeats.
struct StudyCost {
  double min = 0, median = 0, max = 0;
};

struct StudyCell {
  std::string solver, method;
  int iterations = 0;    ///< per substep, for methods that iterate; otherwise 0
  double substep_s = 0;  ///< the step of the method
  int substeps = 1;      ///< per step of the solver, between two forces
  enum class State : std::uint8_t {
    measured,
    refused,      ///< the solver does not start: the step is not stable, or the method cannot compute the scene
    unavailable,  ///< the solver is not built in, or there is no device
    diverged      ///< a value is not finite, or the error is more than ten times the motion itself
  } state = State::measured;
  std::string reason;  ///< for every state except `measured`
  StudyValues error;
  StudyValues order;  ///< log(error ratio) / log(step ratio) against the next coarser step of the same solver and method
  bool at_floor(StudyQuantity q, const StudyValues& estimate) const { return error[q] <= estimate[q]; }
  StudyCost cpu;   ///< CPU time of the process, all threads
  StudyCost wall;  ///< elapsed time; on a busy machine longer than necessary
  int repeats = 0;
  std::string machine;  ///< on which the costs were measured, if the cells of the study come from several
};
const char* name_of(StudyCell::State state);

/// The reference: a Richardson extrapolation of three runs in double, each with half the step of the one before.
struct StudyReference {
  std::string method;
  int method_order = 0;           ///< the order on which the extrapolation relies
  double coarsest_substep_s = 0;  ///< the coarsest of the three; the finest is a quarter of it
  StudyValues scale;              ///< rms displacement in m, rms force in N, rms energy in J
  StudyValues estimate;           ///< its own error, in the units of the cells: twice the difference of two extrapolations
  StudyValues order;              ///< the order observed between the three runs
};

struct StudyRecord {
  std::string scenario, file, version;
  std::string machine, compiler, opencl_device;  ///< opencl_device empty: no cell used one
  std::int64_t cpus = 0;                         ///< 0: of several machines
  std::vector<std::string> machines;             ///< of the costs, if these come from several; otherwise empty
  double load = 0;  ///< load of the machine when the study began: runnable processes, mean over a minute
  int repeats = 0;  ///< as asked for
  std::int64_t particles = 0;
  double stiffness_N_per_m = 0, step_limit_s = 0;  ///< the limit is that of the explicit one-evaluation methods
  double step_s = 0;                               ///< step of the scene; tools get new positions at its multiples
  double rest_s = 0, duration_s = 0;               ///< time with the tools at rest before the motion; time judged
  std::int64_t samples = 0;
  StudyReference reference;
  std::vector<StudyCell> cells;
  bool interrupted = false;  ///< interrupted, so cells are missing
};

/// Why the costs of these machines must not be compared with each other; empty if there is at most one.
std::string warning_of(const std::vector<std::string>& machines);

std::string study_table(const StudyRecord& study);
/// One row per cell; the fields of a cell that was not measured are empty.
std::string study_csv(const StudyRecord& study);
std::string study_json(const StudyRecord& study);
/// Error (x) against CPU seconds per simulated second (y), both logarithmic; a line per solver, method and iterations.
std::string study_svg(const StudyRecord& study, StudyQuantity quantity);

}  // namespace evenstep
