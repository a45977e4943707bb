#pragma once
/// The choices that `evenstep advise` compares, and the scenario of each. A further choice is one more entry of the list.

#include <optional>
#include <string>
#include <vector>

#include "evenstep/campaigns/advise.h"
#include "evenstep/format/scenario.h"
#include "evenstep/time/time.h"

namespace evenstep::internal {

/// What a tick of the device sends.
struct AdviceRenderer {
  const char* name;
  const char* of_line;  ///< [[device]] render of the device that shows the jumps
  const char* of_hand;  ///< of the device that the hand holds
  bool needs_stiffness, needs_springs;
};
const AdviceRenderer& renderer_called(const std::string& name);

/// What decides when steps are computed and played: a map, a governor, and how many segments may be late.
struct AdvicePace {
  StrategyKind map = StrategyKind::direct;
  std::string bandwidth;  ///< as [remap] takes it; empty: the map has none
  std::optional<WhatIf> governor;
  std::optional<double> jump;  ///< [remap] jump; empty: its default
  bool at_rate = false;        ///< the latency of AdviseOptions::rate
  bool adaptive = false;       ///< a latency that adapts, at most the least one for which nothing is late
  bool all_renderers = false;  ///< false: with the plainest and the local model, which suffices to compare
};
/// The paces worth comparing for segments with or without pauses, and with or without a clock of their own (t(n)), as they
/// are and with each of these governors.
std::vector<AdvicePace> paces(bool has_pauses, bool has_clock, const AdviseOptions& options,
                              const std::vector<WhatIf>& governors);
/// The renderers among those asked for that go with a pace; at least one.
std::vector<const AdviceRenderer*> renderers_of(const AdvicePace& pace, const std::vector<std::string>& names);
/// The share of the time in which nothing is drawn and no step runs after a segment's work.
double waiting_share(const std::vector<SegmentTiming>& segments);
/// What is compared by default, for these segments. Spread comes first where they wait for a tenth of the time or more.
std::vector<WhatIf> default_governors(const std::vector<SegmentTiming>& segments);

/// The speed at which the hand that stops moves, if its mean speed is that of the line's hand.
double stops_speed(double speed_m_per_s);

/// What the scenarios of all choices have in common.
struct AdviceSetting {
  std::string input;
  Rate sampling;
  double speed_m_per_s = 0;
  double mass_kg = 0, damping_N_s_per_m = 0;
  Rate firmware_rate;
};

struct AdviceLatency {
  Duration latency, lead;
  double late = 0;        ///< share of the segments that are late with it at the worst phase
  bool adaptive = false;  ///< `latency` is the most it may become
};
/// What the scenario of one choice has besides.
struct AdviceScenario {
  std::string name;
  std::string trace;                      ///< the file beside it that has the segments
  std::optional<FrameGovernor> governor;  ///< over these segments
  Duration warmup;
  double stiffness_N_per_m = 1;
  double search_from_N_per_m = 1;
  std::optional<double> search_to_N_per_m;  ///< `evenstep study` of it finds the largest stable stiffness up to there
  std::optional<AdviceLatency> latency;     ///< empty: the least for which nothing is late
};
/// Without expectations. `stops`: instead of its devices, one whose hand stops again and again, to see what runs on there.
std::string scenario_text(const AdviceSetting& setting, const AdvicePace& pace, const AdviceRenderer& renderer,
                          const AdviceScenario& own, bool stops = false);
/// What its run must give: the numbers of the choice.
std::string expectations_text(const AdviceChoice& choice);
std::string stops_expectations_text(const AdviceChoice& choice);

}  // namespace evenstep::internal
