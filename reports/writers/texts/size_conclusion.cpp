#include "size_conclusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "evenstep/reports/json.h"

namespace evenstep {
namespace {

constexpr double kNearBound = 1.25;      // times the pause bound
constexpr double kMaterial = 0.01;       // a saving below this share of the latency does not count
constexpr std::size_t kMostKinds = 8;    // rows of the table
constexpr std::int64_t kAlikePart = 10;  // intervals that differ by less than a tenth are alike

using internal::kSmooth;
using internal::ms;

std::size_t place_of(const SizeRecord& record, const SizeStrategy& strategy) {
  return static_cast<std::size_t>(&strategy - record.strategies.data());
}

std::string some(const SizeHitches& kind) {
  return kind.count == 1 ? name_of(kind.what) : fmt::format("{} {}s", kind.count, name_of(kind.what));
}

std::string range(Duration least, Duration most) {
  const std::string low = fmt::format("{:.4g}", ms(least)), high = fmt::format("{:.4g}", ms(most));
  return low == high ? low : low + " to " + high;
}

std::string how_often(const SizeHitches& kind, const SizeRecord& record) {
  if (kind.count == 1) return fmt::format("once, at {:.4g} s", seconds(kind.first));
  if (kind.regular(record.segment)) return fmt::format("every {:.4g} s", seconds(kind.median_between));
  const std::string least = fmt::format("{:.3g}", seconds(kind.least_between));
  const std::string most = fmt::format("{:.3g}", seconds(kind.most_between));
  return (least == most ? least : least + " to " + most) + " s apart";
}

std::string stiffness(const SizeRecord& record, double N_per_m) {
  return fmt::format("{:.3g} N/m at {:.3g} N s/m", N_per_m, record.damping_N_s_per_m);
}

/// Whether the map or the machine is to blame.
std::string blame(const SizeRecord& record, const SizeStrategy& use) {
  const Duration bound = (record.linear ? *record.linear : record.held).pause;
  if (bound.ns <= 0) return "";
  if (record.forces_travel)
    return "  The bounds leave out how long forces are on their way to the device, so they do not judge the map here.\n";
  const double times = static_cast<double>(use.any_phase.latency.ns) / static_cast<double>(bound.ns);
  if (times < 1)
    return fmt::format("  That is less than the pause bound of {:.4g} ms: the worst comes before the map has slots.\n",
                       ms(bound));
  if (times <= kNearBound)
    return fmt::format("  The pause bound is {:.4g} ms: the machine sets the latency, and another map would win little.\n",
                       ms(bound));
  std::string out = fmt::format("  That is {:.2f} times the pause bound of {:.4g} ms", times, ms(bound));
  if (use.pauses_bound && *use.pauses_bound > bound)
    out += fmt::format(", and {:.2f} times the {:.4g} ms that\n  pauses so close to each other take at its jump",
                       static_cast<double>(use.any_phase.latency.ns) / static_cast<double>(use.pauses_bound->ns),
                       ms(*use.pauses_bound));
  return out + ": a part of it is how the map follows this timing.\n";
}

std::string compared(const SizeRecord& record, const SizeStrategy& use) {
  std::string out;
  for (const SizeStrategy& other : record.strategies) {
    if (&other == &use || other.any_phase.culprit.step < 0 || !other.jump_seen) continue;
    out += fmt::format("  {} needs {:.4g} ms; its reads jump by {:.2g} slots, those of {} by {:.2g}.\n", other.name,
                       ms(other.any_phase.latency), other.velocity_jump, use.name, use.velocity_jump);
  }
  return out;
}

/// Which parts of the pause are worth to be made shorter, and how.
std::string shorter_pauses(const SizeRecord& record) {
  std::string out;
  const PauseParts& pause = record.pause;
  // Steps that are spread already wait for up to a slot.
  const bool waits = pause.is_material(pause.waiting) && pause.waiting * record.steps > record.length;
  if (waits || pause.is_material(pause.unrecorded))
    out += fmt::format(" {} steps that\n  wait for their slots instead of coming in a burst help: --spread says how much.",
                       waits ? "As it waits," : "If it waits where nothing is recorded,");
  if (pause.is_material(pause.drawing)) out += " A shorter visualization helps, or steps\n  between its parts.";
  return out + "\n";
}

/// What all hitches together cost, and which kind it would save most to mend.
std::string worth(const SizeRecord& record, const SizeStrategy& use) {
  if (record.hitches.empty()) {
    const std::string usual = "  Nothing took clearly longer than usual: every cycle needs about as much.";
    if (record.visualizations == 0)
      return usual + " It has no\n  visualization: what helps are results that come sooner, more often or more evenly.\n";
    return usual + shorter_pauses(record);
  }
  const std::size_t map = place_of(record, use);
  const auto alone = [&](const SizeHitches& kind) { return kind.mended[map].latency; };
  const Duration latency = use.any_phase.latency;
  const auto saves = [&](Duration mended) {
    return static_cast<double>((latency - mended).ns) > kMaterial * static_cast<double>(latency.ns);
  };
  const SizeHitches::Mended& all = record.hitches.back().mended[map];
  if (!saves(all.with_all_above))
    return fmt::format("  Hitches do not set the latency: without any, {:.6f} ms would be needed. The usual cycle does.\n",
                       ms(all.with_all_above));
  std::string out = fmt::format("  Without its hitches {:.6f} ms would do, and the loop would carry {}.\n",
                                ms(all.with_all_above), stiffness(record, all.stiffness_N_per_m));
  const auto best = std::min_element(record.hitches.begin(), record.hitches.end(),
                                     [&](const auto& a, const auto& b) { return alone(a) < alone(b); });
  if (!saves(alone(*best))) return out + "  No kind saves much alone: they hide each other.\n";
  const std::string these =
      fmt::format("the {} of {} ms, {}", some(*best), range(best->shortest, best->longest), how_often(*best, record));
  if (alone(*best) == all.with_all_above) return out + fmt::format("  All of that is {}.\n", these);
  return out + fmt::format("  Mend first {}: that alone leaves {:.6f} ms.\n", these, ms(alone(*best)));
}

/// What the size is worth for the next recording.
std::string unseen(const SizeStrategy& use) {
  if (use.unseen.empty()) return "";
  const SizeUnseen all = use.all_unseen();
  const std::string change = use.trust.change ? "  No confidence is given: " + not_one_process(use.trust) + "\n" : "";
  return change + "  " + text(all) + (all.late == 0 ? "\n" : "\n  Expect the like of the next recording.\n");
}

std::string tables(const SizeRecord& record, const SizeStrategy& use) {
  std::string out =
      fmt::format("\n[remap]\nlatency = \"{:.6f} ms\"\nlead = \"{:.6f} ms\"\n", ms(use.any_phase.latency), ms(use.lead));
  if (!record.trace.empty()) {
    out += fmt::format("\n[timing]\ntrace = {}\n", json_text(Json(record.trace)));
    return record.trace_roles.empty() ? out : out + fmt::format("roles = {}\n", record.trace_roles);
  }
  if (record.segments_from != "cycle" && record.segments_from != "step") return out;  // the scenario has a [timing]
  return out + "\n# [timing] takes the one segment of this file: --timing timing.csv writes those that were sized.\n";
}

}  // namespace

std::string text(const SizeUnseen& all) {
  if (all.late == 0) return "Sized on its first parts, it is never late in the parts after them.";
  return fmt::format(
      "Sized on its first parts, it is late in {:.2g} % of the segments of the parts after them, by up to {:.4g} ms.",
      100 * static_cast<double>(all.late) / static_cast<double>(all.played), ms(std::max(all.late_by, all.missing_by)));
}

SizeUnseen SizeStrategy::all_unseen() const {
  SizeUnseen all;
  for (const SizeUnseen& one : unseen) {
    const SizeUnseen before = std::exchange(all, one);
    all.played += before.played;
    all.late += before.late;
    all.late_by = std::max(all.late_by, before.late_by);
    all.missing_by = std::max(all.missing_by, before.missing_by);
  }
  return all;
}

bool SizeHitches::regular(Duration segment) const {
  const Duration slack{median_between.ns / kAlikePart + segment.ns};
  return count > 2 && median_between - least_between <= slack && most_between - median_between <= slack;
}

const char* name_of(SizeHitches::What what) {
  switch (what) {
    case SizeHitches::What::visualization:
      return "visualization";
    case SizeHitches::What::step:
      return "step";
    case SizeHitches::What::waiting:
      return "wait";
    case SizeHitches::What::gap:
      return "gap";
  }
  return "";
}

const SizeStrategy* strategy_to_use(const SizeRecord& record) {
  const SizeStrategy* use = nullptr;
  const auto better = [](const SizeStrategy& a, const SizeStrategy& b) {
    const bool smooth = a.velocity_jump <= kSmooth;
    if (smooth != (b.velocity_jump <= kSmooth)) return smooth;
    return smooth ? a.any_phase.latency < b.any_phase.latency : a.velocity_jump < b.velocity_jump;
  };
  for (const SizeStrategy& strategy : record.strategies) {
    if (strategy.any_phase.culprit.step < 0 || strategy.for_comparison || !strategy.jump_seen) continue;
    if (use == nullptr || better(strategy, *use)) use = &strategy;
  }
  return use;
}

std::string lacking(const SizeRecord& record) {
  const SizeFit& fit = *record.fit;
  if (fit.fits()) return "";
  if (!fit.unknown.empty()) return fmt::format("what {} needs for so long cannot be known: {}", fit.map, fit.unknown);
  std::string out;
  const auto time = [&](const char* what, const std::optional<Duration>& has, Duration needed) {
    if (has.value_or(needed) < needed)
      out += fmt::format("{} {:.6f} ms is {:.6f} ms too little: {} needs {:.6f} ms. ", what, ms(*has), ms(needed - *has),
                         fit.map, ms(needed));
  };
  time("latency", fit.latency, fit.needed_latency);
  time("lead", fit.lead, fit.needed_lead);
  const auto ring = [&](const char* what, const std::optional<std::int64_t>& has, std::int64_t needed) {
    if (has.value_or(needed) < needed)
      out += fmt::format("A ring of {} {} is {} too small: {} are needed{}. ", *has, what, needed - *has, needed,
                         fit.latency ? " with that latency" : "");
  };
  ring("samples", fit.samples, fit.needed_samples);
  ring("forces", fit.forces, fit.needed_forces);
  const auto used = std::find_if(record.strategies.begin(), record.strategies.end(),
                                 [&](const SizeStrategy& one) { return one.name == fit.map; });
  // Its lines are indented by two.
  const std::string why = worth(record, *used);
  for (std::size_t i = 2; i < why.size(); ++i)
    if (why[i] != ' ' || out.back() != ' ') out += why[i] == '\n' ? ' ' : why[i];
  return out.substr(0, out.find_last_not_of(' ') + 1);
}

namespace internal {

std::string fit_text(const SizeRecord& record) {
  if (!record.fit) return "";
  const SizeFit& fit = *record.fit;
  std::string out = fmt::format("\n  Does it fit? ({})\n", fit.map);
  if (!fit.unknown.empty()) return out + "  nobody can say\nDOES NOT FIT\n";
  const auto row = [&](const char* what, const std::string& has, const std::string& needed, bool enough) {
    out += fmt::format("  {:<13} {:>16} {:>16} {:>4}\n", what, has, needed, enough ? "yes" : "no");
  };
  out += fmt::format("  {:<13} {:>16} {:>16}\n", "", "has", "needed");
  const auto time = [&](const char* what, const std::optional<Duration>& has, Duration needed) {
    if (has) row(what, fmt::format("{:.6f}", ms(*has)), fmt::format("{:.6f}", ms(needed)), *has >= needed);
  };
  time("latency, ms", fit.latency, fit.needed_latency);
  time("lead, ms", fit.lead, fit.needed_lead);
  const auto ring = [&](const char* what, const std::optional<std::int64_t>& has, std::int64_t needed) {
    if (has) row(what, std::to_string(*has), std::to_string(needed), *has >= needed);
  };
  ring("samples", fit.samples, fit.needed_samples);
  ring("forces", fit.forces, fit.needed_forces);
  return out + (fit.fits() ? "FITS\n" : "DOES NOT FIT\n");
}

std::string why_refused(const SizePer& per, const SizeTrust& trust) {
  return (trust.one_process() ? per.refused : not_one_process(trust)) +
         (per.to_record.ns > 0 ? fmt::format("; {:.6g} s more of it would do", seconds(per.to_record)) : "");
}

std::string hitches_text(const SizeRecord& record) {
  const SizeStrategy* use = strategy_to_use(record);
  if (use == nullptr || record.hitches.empty()) return "";
  std::string out = fmt::format("\n  Hitches, by kind; latency of {} if all of a kind had been as usual\n", use->name);
  out += fmt::format("  {:<13} {:>6} {:>18} {:>10} {:>24} {:>13} {:>15} {:>6}\n", "", "count", "took, ms", "usual, ms",
                     "how often", "mended, ms", "with all above", "N/m");
  for (std::size_t i = 0; i < std::min(record.hitches.size(), kMostKinds); ++i) {
    const SizeHitches& kind = record.hitches[i];
    const SizeHitches::Mended& mended = kind.mended[place_of(record, *use)];
    out += fmt::format("  {:<13} {:>6} {:>18} {:>10.4g} {:>24} {:>13.6f} {:>15.6f} {:>6.3g}\n", name_of(kind.what),
                       kind.count, range(kind.shortest, kind.longest), ms(kind.usual), how_often(kind, record),
                       ms(mended.latency), ms(mended.with_all_above), mended.stiffness_N_per_m);
  }
  if (record.hitches.size() > kMostKinds)
    out += fmt::format("  {} kinds of shorter ones are in --json.\n", record.hitches.size() - kMostKinds);
  return out;
}

std::string answer(const SizeRecord& record) {
  const SizeStrategy* use = strategy_to_use(record);
  if (use == nullptr) return "  No map can be named: a map has slots once it has seen a whole segment; record more.\n";
  return fmt::format(
      "  Use {} with a latency of {:.6f} ms, a lead of {:.6f} ms, and rings for {} samples and {} forces:\n  nothing "
      "underruns in this timing, at any phase of the device. The loop carries {}.\n",
      use->name, ms(use->any_phase.latency), ms(use->lead), use->interaction_capacity, use->force_capacity,
      stiffness(record, use->any_phase.stiffness_limit_N_per_m));
}

std::string reasons_text(const SizeRecord& record) {
  const SizeStrategy* use = strategy_to_use(record);
  if (use == nullptr) return "";
  const std::string pause = text(record.pause);
  return fmt::format("\n  Why {} with {:.6f} ms\n", use->name, ms(use->any_phase.latency)) +
         (pause.empty() ? "" : "  " + pause + "\n") + worth(record, *use) + blame(record, *use) + compared(record, *use) +
         unseen(*use) + tables(record, *use);
}

}  // namespace internal

std::string not_one_process(const SizeTrust& trust) {
  if (trust.change)
    return fmt::format(
        "from {:.4g} s on it behaves differently than before; record without such a change, or so long that it has many.",
        seconds(trust.change->from));
  return fmt::format("too short to tell whether it changes, {} segments in blocks of {}.", trust.segments, trust.block);
}

std::string text(const TrustedLatency& latency) {
  if (!latency.per.refused.empty()) return "cannot be known: " + internal::why_refused(latency.per, latency.trust);
  return fmt::format("{:.6f} ms with a lead of {:.6f} ms", internal::ms(latency.per.latency),
                     internal::ms(latency.per.lead));
}

}  // namespace evenstep
