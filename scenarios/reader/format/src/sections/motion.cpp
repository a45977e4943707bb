// [[device]] motion
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/format/load.h"
#include "evenstep/recordings/motion_csv.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

constexpr std::string_view kMotions =
    "still|constant-velocity|back-and-forth|sine|ramp-stop|stick-slip|recorded|minimum-jerk|hand";
constexpr std::string_view kPaths = "still|constant-velocity|back-and-forth|sine|ramp-stop|stick-slip|recorded|minimum-jerk";

RecordedMotion read_recorded(const Table& motion, Errors& errors) {
  const Value path = motion.at("file");
  MotionCsv csv = read_motion_csv(path_from(path));
  for (const Diagnostic& error : csv.error_or({})) {
    if (error.line == 0) {
      errors.add(path.place, fmt::format("'file': '{}' {}", error.file, error.message));
    } else {
      errors.add({error.file, error.line, error.column}, error.message);
    }
  }
  return std::move(csv).value_or({});
}

Motion read_stick_slip(const ScenarioReading& reading, const Table& motion) {
  const NominalUnits& nominal = reading.scenario.nominal;
  return StickSlip{motion.vector("velocity"), motion.span("stick", nominal, reading.errors),
                   motion.span("slip", nominal, reading.errors)};
}

Motion read_minimum_jerk(const ScenarioReading& reading, const Table& motion) {
  MinimumJerk out;
  for (const Table& move : motion.tables("moves")) {
    out.moves.push_back({move.vector("to"), move.span("duration", reading.scenario.nominal, reading.errors),
                         move.span("rest", reading.scenario.nominal, reading.errors)});
  }
  if (out.moves.empty())
    reading.errors.add(motion.place("moves"),
                       "'moves' is empty; write [{ to = [\"10 mm\", \"0 mm\", \"0 mm\"], duration = \"0.4 s\" }]");
  return out;
}

Motion read_shape(const ScenarioReading& reading, const Table& motion) {
  const std::string kind = motion.text("kind");
  if (kind == "still") return Still{};
  if (kind == "sine") return Sine{motion.vector("amplitude"), motion.rate("frequency")};
  if (kind == "recorded") return read_recorded(motion, reading.errors);
  const bool spans_known = reading.scenario.nominal.known;  // if not, [timing] is faulty: they may need its units
  if (kind == "minimum-jerk") return spans_known ? read_minimum_jerk(reading, motion) : Motion(Still{});
  if (kind == "stick-slip") return spans_known ? read_stick_slip(reading, motion) : Motion(Still{});
  const ConstantVelocity ramp{motion.vector("velocity"), motion.smooth("start")};
  if (kind == "constant-velocity") return ramp;
  if (!spans_known) return Still{};
  if (kind == "back-and-forth") {
    const NominalUnits& nominal = reading.scenario.nominal;
    return BackAndForth{ramp, motion.span("straight", nominal, reading.errors),
                        motion.span("turn", nominal, reading.errors)};
  }
  const Duration stop = motion.span("stop", reading.scenario.nominal, reading.errors);
  if (stop < ramp.smooth_start) {
    reading.errors.add(motion.place("stop"), fmt::format("'stop': {} is within the smooth start of {}; stop later",
                                                         in_ms(stop), in_ms(ramp.smooth_start)));
  }
  return RampStop{ramp, RealTime{stop.ns}};
}

ProgrammedMotion read_programmed(const ScenarioReading& reading, const Table& motion) {
  ProgrammedMotion programmed{read_shape(reading, motion), {}};
  if (motion.has("delay")) programmed.begin = RealTime{motion.span("delay", reading.scenario.nominal, reading.errors).ns};
  return programmed;
}

/// Checks that the integration of the hand can follow its motion (device/hand.h).
void check_hand(const HandSpec& hand, const Table& motion, Errors& errors) {
  const double frequency_per_s = std::sqrt(hand.total_stiffness_N_per_m() / hand.total_mass_kg());
  const double decay_per_s = hand.total_damping_N_s_per_m() / hand.total_mass_kg();
  if (frequency_per_s > kFastestHand_per_s) {
    errors.add(motion.place("mass"),
               fmt::format("'mass': on its springs the hand swings with {:.4g} /s, and {:g} /s is the most; "
                           "write more mass or less stiffness",
                           frequency_per_s, kFastestHand_per_s));
  } else if (decay_per_s > kFastestHand_per_s) {
    errors.add(motion.place("mass"),
               fmt::format("'mass': the damping stops the hand with {:.4g} /s, and {:g} /s is the most; write "
                           "more mass or less damping",
                           decay_per_s, kFastestHand_per_s));
  }
}

HandSpec read_hand(const Table& motion, Errors& errors) {
  HandSpec hand{motion.si("mass"), motion.si("damping"), motion.si("stiffness")};
  if (motion.has("arm")) {
    const Table arm = motion.table("arm");
    hand.arm = {arm.si("mass"), arm.si("damping"), arm.si("stiffness")};
  }
  hand.push_N = motion.vector("push");
  hand.offset_m = motion.vector("offset");
  hand.velocity_m_per_s = motion.vector("velocity");
  check_hand(hand, motion, errors);
  return hand;
}

}  // namespace

void read_motion(const ScenarioReading& reading, const Table& device, DeviceSpec& spec) {
  if (!device.has("motion")) return;
  const Table motion = device.table("motion");
  if (motion.text("kind") != "hand") {
    spec.motion = read_programmed(reading, motion);
    return;
  }
  spec.hand = read_hand(motion, reading.errors);
  if (motion.has("path")) spec.motion = read_programmed(reading, motion.table("path"));
}

namespace {

// A key is a few full lines.
// clang-format off
const std::vector<Field>& own_fields() {
  static const std::vector<Field> rows{
      {.table = "device.motion", .key = "kind", .forms = kWord,
       .meaning = "Every motion rests at its start for t < 0. `hand`: a mass that feels the force.",
       .words = kMotions, .required = true, .example = "\"still\""},
      {.table = "device.motion", .key = "velocity", .forms = kQuantity, .shape = Shape::three,
       .default_toml = "[\"0 m/s\", \"0 m/s\", \"0 m/s\"]",
       .meaning = "At t = 0.",
       .kinds = "hand", .dimension = D::velocity},
      {.table = "device.motion", .key = "velocity", .forms = kQuantity, .shape = Shape::three,
       .meaning = "After the start; of `stick-slip` the mean.",
       .kinds = "constant-velocity|back-and-forth|ramp-stop|stick-slip", .required = true, .dimension = D::velocity,
       .example = "[\"0.1 m/s\", \"0 m/s\", \"0 m/s\"]"},
      {.table = "device.motion", .key = "start", .forms = kSmooth, .default_toml = "\"smooth 0 s\"",
       .meaning = "The velocity rises as a smoothstep over this time.",
       .kinds = "constant-velocity|back-and-forth|ramp-stop", .range = between(0, kLongestRun_s),
       .example = "\"smooth 0.2 s\""},
      {.table = "device.motion", .key = "straight", .forms = kSpan,
       .meaning = "How long it then goes at that velocity, there and, after a turn, back.",
       .kinds = "back-and-forth", .required = true, .range = above(0, kLongestRun_s), .example = "\"4 s\""},
      {.table = "device.motion", .key = "turn", .forms = kSpan,
       .meaning = "How long it takes to turn around smoothly. Straightness is judged between the turns "
                  "(docs/reference/metrics.md).",
       .kinds = "back-and-forth", .required = true, .range = above(0, kLongestRun_s), .example = "\"0.2 s\""},
      {.table = "device.motion", .key = "stop", .forms = kSpan,
       .meaning = "Dead stop at this time after its begin.",
       .kinds = "ramp-stop", .required = true, .range = above(0, kLongestRun_s), .example = "\"1 s\""},
      {.table = "device.motion", .key = "stick", .forms = kSpan,
       .meaning = "How long it holds at the start of each period `stick` + `slip`.",
       .kinds = "stick-slip", .required = true, .range = between(0, kLongestRun_s), .example = "\"90 ms\""},
      {.table = "device.motion", .key = "slip", .forms = kSpan,
       .meaning = "How long it then moves, evenly, to where the mean velocity has brought it.",
       .kinds = "stick-slip", .required = true, .range = above(0, kLongestRun_s), .example = "\"10 ms\""},
      {.table = "device.motion", .key = "amplitude", .forms = kQuantity, .shape = Shape::three,
       .meaning = "x = amplitude (1 - cos(2 pi f t)) / 2.",
       .kinds = "sine", .required = true, .dimension = D::length, .example = "[\"10 mm\", \"0 mm\", \"0 mm\"]"},
      {.table = "device.motion", .key = "frequency", .forms = kRate,
       .meaning = "f.",
       .kinds = "sine", .required = true, .range = above(0, 10'000), .example = "\"2 Hz\""},
      {.table = "device.motion", .key = "file", .forms = kFile,
       .meaning = "CSV with the header t_s,x_m,y_m,z_m and increasing times; linear between rows, held at the ends.",
       .kinds = "recorded", .required = true, .example = "\"motion.csv\""},
      {.table = "device.motion", .key = "delay", .forms = kSpan, .default_toml = "\"0 s\"",
       .meaning = "The motion begins this much after t = 0.",
       .kinds = "constant-velocity|back-and-forth|sine|ramp-stop|stick-slip|recorded|minimum-jerk",
       .range = between(0, kLongestRun_s)},
      {.table = "device.motion", .key = "moves", .forms = kTable, .shape = Shape::list,
       .meaning = "One after the other, from the origin on; each from rest to rest with the least jerk.",
       .kinds = "minimum-jerk", .required = true,
       .example = "[{ to = [\"10 mm\", \"0 mm\", \"0 mm\"], duration = \"0.4 s\" }]"},
      {.table = "device.motion", .key = "mass", .forms = kQuantity,
       .meaning = "Mass of the device's moving part.",
       .kinds = "hand", .required = true, .dimension = D::mass, .range = above(0), .example = "\"0.2 kg\""},
      {.table = "device.motion", .key = "damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
       .meaning = "Damping of the device, against its motion.",
       .kinds = "hand", .dimension = D::damping, .range = at_least(0)},
      {.table = "device.motion", .key = "stiffness", .forms = kQuantity, .default_toml = "\"0 N/m\"",
       .meaning = "Stiffness of the spring that pulls the hand to its path.",
       .kinds = "hand", .dimension = D::stiffness, .range = at_least(0)},
      {.table = "device.motion", .key = "path", .forms = kTable,
       .meaning = "Where the hand intends to go: any other motion. Default: it intends to stay at the origin.",
       .kinds = "hand"},
      {.table = "device.motion", .key = "arm", .forms = kTable,
       .meaning = "The arm that grips the device rigidly. Default: nobody holds the device, which is the worst case.",
       .kinds = "hand"},
      {.table = "device.motion", .key = "push", .forms = kQuantity, .shape = Shape::three,
       .default_toml = "[\"0 N\", \"0 N\", \"0 N\"]",
       .meaning = "A constant force besides.",
       .kinds = "hand", .dimension = D::force},
      {.table = "device.motion", .key = "offset", .forms = kQuantity, .shape = Shape::three,
       .default_toml = "[\"0 mm\", \"0 mm\", \"0 mm\"]",
       .meaning = "Distance from the path at t = 0, where the hand is released.",
       .kinds = "hand", .dimension = D::length, .range = between(-2, 2)},
      {.table = "device.motion.moves", .key = "to", .forms = kQuantity, .shape = Shape::three,
       .meaning = "Where it ends.",
       .required = true, .dimension = D::length, .example = "[\"10 mm\", \"0 mm\", \"0 mm\"]"},
      {.table = "device.motion.moves", .key = "duration", .forms = kSpan,
       .meaning = "Length of the move.",
       .required = true, .range = above(0, kLongestRun_s), .example = "\"0.4 s\""},
      {.table = "device.motion.moves", .key = "rest", .forms = kSpan, .default_toml = "\"0 s\"",
       .meaning = "How long it stays there, before the next move.",
       .range = between(0, kLongestRun_s)},
      {.table = "device.motion.arm", .key = "mass", .forms = kQuantity,
       .meaning = "Added to the device's.",
       .required = true, .dimension = D::mass, .range = at_least(0), .example = "\"0.554 kg\""},
      {.table = "device.motion.arm", .key = "damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
       .meaning = "Against its motion relative to the path.",
       .dimension = D::damping, .range = at_least(0)},
      {.table = "device.motion.arm", .key = "stiffness", .forms = kQuantity, .default_toml = "\"0 N/m\"",
       .meaning = "Towards the path.",
       .dimension = D::stiffness, .range = at_least(0)},
  };
  return rows;
}
// clang-format on

/// The intended path of a hand can be any motion except a hand.
std::vector<Field> path_fields() {
  std::vector<Field> rows;
  for (Field field : own_fields()) {
    if (field.table == "device.motion.moves")
      field.table = "device.motion.path.moves";
    else if (field.table == "device.motion" && field.kinds != "hand")
      field.table = "device.motion.path";
    else
      continue;
    if (field.key == "kind") {
      field.words = kPaths;
      field.meaning = "Every motion rests at its start for t < 0.";
    }
    rows.push_back(field);
  }
  return rows;
}

}  // namespace

const std::vector<Field>& motion_fields() {
  static const std::vector<Field> rows = joined(own_fields(), path_fields());
  return rows;
}

}  // namespace evenstep::internal
