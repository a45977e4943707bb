#pragma once
/// `evenstep advise`: what can be chosen for a timing, and what each choice costs. Each choice of map, governor, latency and
/// renderer is a scenario, which is run; its numbers are those of that run, of the sizing (size.h) and of the laws of
/// stiffness (device/stiffness_laws.h). docs/choose/advise.md says what is chosen and compared.

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/campaigns/size.h"
#include "evenstep/campaigns/what_if.h"
#include "evenstep/recordings/recording.h"
#include "evenstep/reports/advice_record.h"
#include "evenstep/text/diagnostic.h"

namespace evenstep {

/// Each choice is a run of its own, and several are in memory at a time.
inline constexpr std::int64_t kMostAdviceSteps = 300'000;

struct AdviseOptions {
  Rate sampling{1000, 1};         ///< of the device; for a scenario, that of its slowest device
  std::optional<Rate> step_size;  ///< SizeOptions::step_size, of a recording
  double rate = 0.01;             ///< share of segments that may be late in the second choice of latency, in (0, 1)
  double damping_N_s_per_m = 1;   ///< of hand and device; above 0
  double mass_kg = 0.2;           ///< of hand and device; above 0
  Rate firmware_rate{4000, 1};    ///< at which a device renders springs by itself; at least 100 Hz
  std::vector<Rate> bandwidths{{1, 1}, {2, 1}};  ///< of `phase_locked`
  std::vector<std::string> renderers{"hold", "linear", "local", "device_spring"};
  /// What a simulator could change (what_if.h), in the form that it can do without knowing the future. Empty: split 2, a
  /// budget of the 90th percentile of the drawings, pace 90 %, own-lane without and with spread; before them spread, where
  /// the segments wait for a tenth of the time.
  std::optional<std::vector<WhatIf>> governors;
  std::string program = "evenstep";  ///< how evenstep is called, for comments in the scenarios
  int threads = 0;                   ///< how many choices run at the same time; 0: one per core. The result is the same
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(double fraction)> progress;
};

struct AdviseResult {
  AdviceRecord record;
  /// The files that the scenarios replay, by name: timing.csv, and one for each change of the simulator that no governor can
  /// make.
  std::map<std::string, std::string> timings;
  std::vector<Diagnostic> errors;  ///< empty: the record is complete
  bool interrupted = false;        ///< then the record is not complete
  std::string damage = {};         ///< as of SizeResult
};

/// For a recording, as size_recording takes it; for a scenario's timing and its slowest device.
AdviseResult advise_recording(const std::string& path, const AdviseOptions& options, const RecordingOptions& recording = {});
AdviseResult advise_scenario(const Scenario& scenario, const AdviseOptions& options);

inline constexpr const char* kAdviceFile = "advice.json";  ///< a folder with this file is one of `evenstep advise`
/// "choice-3.toml"
std::string choice_file(const AdviceChoice& choice);
/// "choice-18-stops.toml", of a map that predicts
std::string stops_file(const AdviceChoice& choice);
/// Writes advice.json, the figure, a page, the timings and the scenario of each choice, all or nothing. Returns what went
/// wrong; empty if nothing did.
std::string write_advice_folder(const std::string& folder, const AdviseResult& result, const std::string& reproduce);

}  // namespace evenstep
