#include "judge.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <cmath>
#include <string_view>

#include "evenstep/harness/run.h"
#include "evenstep/harness/underrun_rate.h"
#include "evenstep/reports/places.h"
#include "evenstep/reports/rate_bound.h"
#include "evenstep/reports/recovery.h"
#include "evenstep/reports/saturation.h"
#include "evenstep/text/suggest.h"
#include "src/plan/foreign_needs.h"

namespace evenstep {
namespace {

using internal::matches;
using internal::remedy_of;
using Verdict = ExpectationResult::Verdict;

std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// The limits of an expectation in the base unit of its metric.
struct Bounds {
  std::optional<double> min, max;
};

/// The limit in the base unit of the metric, or an error text.
Result<double> base_limit(const Limit& limit, const Expectation& expectation, const std::string& signal,
                          const Scenario& scenario, const Nominal& nominal) {
  const std::optional<double> step = step_unit(nominal, signal);
  if (limit.unit == "step" && !step) {
    return Failure(fmt::format("'{}' has no unit 'step': that needs a device with a constant nominal speed{}", signal,
                               signal.find(".force.") != std::string::npos ? ", and for a force a spring" : ""));
  }
  return in_base(limit, base_unit(signal, expectation.metric), step.value_or(0), scenario.nominal);
}

const Limit& any_limit(const Expectation& expectation) { return expectation.max ? *expectation.max : *expectation.min; }

/// Compared in the base unit: a value in the unit of the limit is rounded once more, and would not equal what it equals.
Verdict verdict_of(double base_value, const Bounds& base, bool expect_fail) {
  const bool holds = (!base.min || base_value >= *base.min) && (!base.max || base_value <= *base.max);
  return holds != expect_fail ? Verdict::pass : Verdict::fail;
}

ExpectationResult start(const Expectation& expectation) {
  ExpectationResult result;
  result.file = expectation.place.file;
  result.line = expectation.place.line;
  result.column = expectation.place.column;
  result.signal = result.pattern = expectation.signal;
  result.metric = expectation.metric;
  result.expect_fail = expectation.expect_fail;
  result.because = expectation.because;
  result.unit = any_limit(expectation).unit;
  return result;
}

void make_error(ExpectationResult& result, const std::string& detail) {
  result.verdict = Verdict::error;
  result.detail = detail;
}

ExpectationResult error_of(const Expectation& expectation, const std::string& signal, const std::string& detail) {
  ExpectationResult result = start(expectation);
  result.signal = signal;
  make_error(result, detail);
  return result;
}

ExpectationResult nothing_judged(const Expectation& expectation, const std::string& signal) {
  std::string detail = "no sample was judged: the run has no value for this signal and metric";
  if (signal != expectation.signal)
    detail += fmt::format("; '{}' leaves no signal out, so narrow it if this one needs none", expectation.signal);
  return error_of(expectation, signal, detail);
}

ExpectationResult skipped(const Expectation& expectation) {
  ExpectationResult result = start(expectation);
  for (const auto& [limit, out] : {std::pair(&expectation.min, &result.min), std::pair(&expectation.max, &result.max)}) {
    if (*limit && (*limit)->unit == result.unit) *out = (*limit)->number;
  }
  result.verdict = Verdict::skipped;
  result.detail = fmt::format("for the {} clock only", expectation.clock);
  return result;
}

ExpectationResult judge_signal(const Expectation& expectation, const std::string& signal, double base_value,
                               const Scenario& scenario, const Nominal& nominal) {
  ExpectationResult result = start(expectation);
  result.signal = signal;
  // Both limits are shown in the unit of the first one that is written.
  const auto shown = [&](double in_base) {
    return *in_unit(in_base, result.unit, base_unit(signal, expectation.metric), step_unit(nominal, signal).value_or(0),
                    scenario.nominal);
  };
  const auto fail = [&](const std::string& error) {
    make_error(result, error);
    return result;
  };
  Bounds base;
  for (const auto& [limit, bound] : {std::pair(&expectation.max, &base.max), std::pair(&expectation.min, &base.min)}) {
    if (!*limit) continue;
    const Result<double> value = base_limit(**limit, expectation, signal, scenario, nominal);
    if (!value) return fail(value.error());
    *bound = *value;
    (limit == &expectation.max ? result.max : result.min) = (*limit)->unit == result.unit ? (*limit)->number : shown(*value);
  }
  result.value = shown(base_value);
  if (std::isnan(base_value)) {
    make_error(result, "the value is not a number: too few samples, or the data is not finite");
    return result;
  }
  result.verdict = verdict_of(base_value, base, result.expect_fail);
  return result;
}

bool is_recovery(std::string_view metric) { return metric == "recovered" || metric.starts_with("recovery_time"); }

/// How far the result is from failing, relative to the limit.
double margin(const ExpectationResult& result) {
  if (!result.value || std::isnan(*result.value)) return -INFINITY;
  if (is_recovery(result.metric) && std::isinf(*result.value))
    return -INFINITY;  // "never" is no time: it fails a minimum too
  double least = INFINITY;
  if (result.max) least = std::min(least, (*result.max - *result.value) / std::max(std::abs(*result.max), 1e-300));
  if (result.min) least = std::min(least, (*result.value - *result.min) / std::max(std::abs(*result.min), 1e-300));
  return least;
}

/// Of two signals that a `*` matches, an error is worse than any value, what does not hold worse than what does, and
/// otherwise the smaller margin, in which a rounding may hide the difference between holding and not.
bool is_worse(const ExpectationResult& a, const ExpectationResult& b) {
  const auto rank = [](const ExpectationResult& result) {
    const bool holds = (result.verdict == Verdict::pass) != result.expect_fail;
    return result.verdict == Verdict::error ? 2 : holds ? 0 : 1;
  };
  return rank(a) != rank(b) ? rank(a) > rank(b) : margin(a) < margin(b);
}

bool has_metric(const std::string& signal, const std::string& metric) {
  const std::optional<std::vector<std::string>> known = metrics_of_signal(signal);
  return known && std::find(known->begin(), known->end(), metric) != known->end();
}

/// The worst of the signals that the expectation matches and that have a metric of this name, whether it has a value or not.
/// `judge_one` makes a result of a signal and its values.
template <class JudgeOne>
ExpectationResult worst_of(const Expectation& expectation, const Metrics& metrics, JudgeOne judge_one) {
  std::optional<ExpectationResult> worst;
  for (const auto& [signal, values] : metrics) {
    if (!matches(expectation.signal, signal) || !has_metric(signal, expectation.metric)) continue;
    ExpectationResult result = judge_one(signal, values);
    if (!worst || is_worse(result, *worst)) worst = std::move(result);
  }
  return worst ? std::move(*worst) : nothing_judged(expectation, expectation.signal);
}

const DeviceSpec* find_device(const Scenario& scenario, std::string_view name) {
  const auto found = std::find_if(scenario.devices.begin(), scenario.devices.end(),
                                  [&](const DeviceSpec& device) { return device.name == name; });
  return found == scenario.devices.end() ? nullptr : &*found;
}

/// Why the shape of this signal says nothing; empty if it is not saturated or the device expects that.
std::string objection_to_shape(const std::string& signal, const Scenario& scenario,
                               const std::map<std::string, Saturation>& saturated) {
  std::vector<std::string> parts = split(signal);
  if (parts.size() != 3) return "";
  if (parts[0] == "closed_loop") parts = {parts[1], "force", parts[2]};  // it is about the force that was sent
  const auto found = saturated.find(fmt::format("{}", fmt::join(parts, ".")));
  if (found == saturated.end()) return "";
  const DeviceSpec* device = find_device(scenario, parts[0]);
  if (device && device->expects_saturation) return "";
  return fmt::format("saturated: {}, so its shape says nothing; {}; or write saturation = \"expected\" in the [[device]]",
                     text(found->second), remedy_of(found->second.parts.front().cause));
}

ExpectationResult judge_expectation(const Expectation& expectation, const Scenario& scenario, const Nominal& nominal,
                                    const Metrics& metrics, const std::map<std::string, Saturation>& saturated) {
  return worst_of(expectation, metrics, [&](const std::string& signal, const std::map<std::string, double>& values) {
    const auto value = values.find(expectation.metric);
    if (value == values.end()) return nothing_judged(expectation, signal);
    ExpectationResult result = judge_signal(expectation, signal, value->second, scenario, nominal);
    if (!judges_shape(signal, expectation.metric)) return result;
    if (const std::string objection = objection_to_shape(signal, scenario, saturated); !objection.empty())
      make_error(result, objection);
    return result;
  });
}

/// Says where in the run the expectation fails.
void add_place(const Expectation& expectation, const Scenario& scenario, const RunRecord& run, ExpectationResult& result) {
  const auto samples = samples_of(run, result.signal, result.metric);
  if (!samples || result.expect_fail) return;
  const auto in_base = [&](const Limit& limit) {
    return base_limit(limit, expectation, result.signal, scenario, run.nominal);
  };
  const std::optional<Limit>& limit = samples->kind == MetricSamples::Kind::least ? expectation.min : expectation.max;
  const Result<double> unit = in_base({1, result.unit});
  if (limit && unit) locate(result, *samples, *unit, in_base(*limit).value_or(0));
}

/// Judges the bound on a rate of underruns: runs the map alone, with the lead and latency of the run, over as many seeds as
/// are needed.
ExpectationResult judge_rate(const Expectation& expectation, const Scenario& scenario, const internal::RateSignal& signal,
                             const LatencyRecord& latency) {
  ExpectationResult result = start(expectation);
  result.signal = signal.name;
  result.max = expectation.max->number;
  const double most = *in_base(*expectation.max, "1", 0, scenario.nominal);
  const internal::RateBasis basis = internal::rate_basis(scenario, signal.kind);
  const std::int64_t needed = internal::clean_segments(most, *expectation.confidence, basis);
  const std::int64_t seeds = internal::seeds_judged(scenario, expectation, signal.kind, basis);
  if (seeds == 0 || seeds > internal::kMostSeeds) {
    make_error(result, seeds == 0 ? "no segment is judged"
                                  : fmt::format("{} clean segments are needed: more than {} seeds of this run", needed,
                                                internal::kMostSeeds));
    return result;
  }
  const internal::RateCount count =
      internal::count_underrun_segments(scenario, signal, latency.lead, latency.latency, seeds);
  const double rate = internal::underrun_rate_at_most(count, basis, *expectation.confidence);
  result.value = *in_unit(rate, result.unit, "1", 0, scenario.nominal);
  result.verdict = verdict_of(rate, {std::nullopt, most}, result.expect_fail);
  result.detail = fmt::format("{} of {} segments in {} seeds{}; {} clean ones would do", count.hit, count.segments, seeds,
                              basis.alike > 1.05 ? fmt::format(", {:.2g} of which count as one", basis.alike) : "", needed);
  return result;
}

ExpectationResult judge_rates(const Expectation& expectation, const Scenario& scenario, const RunRecord& run,
                              const Metrics& metrics) {
  const std::vector<internal::RateSignal> with_map = internal::rate_signals(scenario);
  return worst_of(expectation, metrics, [&](const std::string& signal, const std::map<std::string, double>&) {
    const auto map = std::find_if(with_map.begin(), with_map.end(), [&](const auto& one) { return one.name == signal; });
    if (map == with_map.end()) {
      return error_of(expectation, signal,
                      "no map was judged: only paper and phase_locked have a rate of underruns with a confidence");
    }
    const auto strategy = std::find_if(run.strategies.begin(), run.strategies.end(),
                                       [&](const StrategyRecord& s) { return s.name == name_of(map->kind); });
    return judge_rate(expectation, scenario, *map, strategy->latency);
  });
}

/// The recovery of each signal that the pattern matches.
std::vector<std::pair<std::string, Recovery>> recoveries(const RunRecord& run, const std::string& pattern) {
  std::vector<std::pair<std::string, Recovery>> found;
  for (const StrategyRecord& strategy : run.strategies) {
    for (std::size_t d = 0; d < strategy.devices.size(); ++d) {
      const std::string signal = strategy.devices[d].name + ".force." + strategy.name;
      if (matches(pattern, signal)) found.emplace_back(signal, recovery_of(run, strategy, d));
    }
  }
  return found;
}

/// For a signal that never recovers. Says why. The signal fails a minimum too, because "never" is no time. Takes back a
/// verdict that the run is too short for: the signal may still recover within a limit that is longer than the rest of the
/// run.
void judge_never(const Expectation& expectation, const Scenario& scenario, const RunRecord& run, const Recovery& recovery,
                 ExpectationResult& result) {
  result.detail = recovery.why;
  if (expectation.metric == "recovered" || !result.value || !std::isinf(*result.value)) return;
  if (!expectation.max) {
    result.verdict = expectation.expect_fail ? Verdict::pass : Verdict::fail;
    return;
  }
  const double limit_s = base_limit(*expectation.max, expectation, result.signal, scenario, run.nominal).value_or(0);
  if (recovery.faults_end == RealTime{} || limit_s <= seconds(recovery.watched)) return;
  make_error(result, fmt::format("{}; to judge this limit the run must last at least {:.6g} s", recovery.why,
                                 seconds(recovery.faults_end + recovery_window(run.nominal)) + limit_s));
}

/// A signal of which nothing is known is never left out beside another one that has recovered.
void judge_recovery(const Expectation& expectation, const Scenario& scenario, const RunRecord& run,
                    ExpectationResult& result) {
  using State = Recovery::State;
  for (const auto& [signal, recovery] : recoveries(run, expectation.signal)) {
    if (recovery.state == State::no_fault && scenario.has_faults_off) {
      result.verdict = Verdict::skipped;
      result.detail = "every fault is switched off, so there is nothing to recover from";
      return;
    }
    if (recovery.state == State::no_fault || recovery.state == State::no_calm || recovery.state == State::too_short) {
      result.signal = signal;
      result.value.reset();
      return make_error(result, recovery.why);
    }
    if (recovery.state == State::never && signal == result.signal) judge_never(expectation, scenario, run, recovery, result);
  }
}

}  // namespace

namespace internal {

bool reaches(const Expectation& condition, const Scenario& scenario, const Nominal& nominal, const Metrics& metrics) {
  for (const auto& [signal, values] : metrics) {
    const auto value = values.find(condition.metric);
    if (!matches(condition.signal, signal) || value == values.end() || !std::isfinite(value->second)) continue;
    if (judge_signal(condition, signal, value->second, scenario, nominal).verdict == Verdict::pass) return true;
  }
  return false;
}

bool matches(const std::string& pattern, const std::string& signal) {
  if (pattern == signal) return true;
  const std::vector<std::string> wanted = split(pattern), given = split(signal);
  return wanted.size() == given.size() && std::equal(wanted.begin(), wanted.end(), given.begin(),
                                                     [](const auto& w, const auto& g) { return w == "*" || w == g; });
}

std::string_view remedy_of(SaturationCause cause) {
  switch (cause) {
    case SaturationCause::clamp:
      return "keep the force below the device's force_limit: a shorter way (kind = \"back-and-forth\") or a softer scene";
    case SaturationCause::slew:
      return "keep its changes below the device's slew_limit: a slower hand or a softer scene";
    case SaturationCause::cut:
      return "judge from after the guard's ramp_up on (warmup), and see which of the guard's cuts counted";
    case SaturationCause::non_finite:
      return "see first_bad_step of the solver";
    case SaturationCause::device_force:
      return "keep the force below what the device can render: a shorter way (kind = \"back-and-forth\") or a softer scene";
    case SaturationCause::device_position:
      return "keep the hand within the device's range: a shorter way (kind = \"back-and-forth\")";
  }
  return "";
}

ExpectationResult judge_by(const Expectation& expectation, const Scenario& scenario, const Nominal& nominal,
                           const Metrics& metrics) {
  Metrics known = metrics;
  std::erase_if(known, [&](const auto& signal) { return !signal.second.contains(expectation.metric); });
  return judge_expectation(expectation, scenario, nominal, known, {});
}

std::vector<ExpectationResult> judge(const Scenario& scenario, const RunRecord& run, const Metrics& metrics) {
  const std::map<std::string, Saturation> saturated = saturations(run);
  std::vector<ExpectationResult> results;
  for (const Expectation& expectation : scenario.expectations) {
    if (!expectation.clock.empty() && expectation.clock != run.clock) {
      results.push_back(skipped(expectation));
      continue;
    }
    ExpectationResult& result = results.emplace_back(
        expectation.confidence ? judge_rates(expectation, scenario, run, metrics)
                               : judge_expectation(expectation, scenario, run.nominal, metrics, saturated));
    if (is_recovery(expectation.metric)) judge_recovery(expectation, scenario, run, result);
    if (result.verdict == Verdict::fail && !expectation.confidence) add_place(expectation, scenario, run, result);
    if (result.verdict == Verdict::fail && expectation.clock == "wall") result.verdict = Verdict::degraded;
  }
  return results;
}

std::vector<ExpectationResult> judge(const Scenario& scenario, const CaseRecord& record) {
  std::vector<ExpectationResult> results;
  for (const Expectation& expectation : scenario.expectations) {
    std::optional<ValueRange> at;
    if (expectation.at) at = ValueRange{(*expectation.at)[0], (*expectation.at)[1]};
    results.push_back(judge_expectation(expectation, scenario, {}, measure(record, at), {}));
  }
  return results;
}

}  // namespace internal

namespace {

/// The device of a signal "<device>.force.<strategy>" if its force in newtons is not known; otherwise nullptr.
const DeviceSpec* without_newtons(const Scenario& scenario, std::string_view signal) {
  for (const DeviceSpec& device : scenario.devices) {
    const bool every = signal.substr(0, 1) == "*";
    const bool is_its_force = signal.substr(0, device.name.size() + 7) == device.name + ".force.";
    if ((every ? signal.find(".force.") != std::string_view::npos : is_its_force) && !knows_newtons(device.driver))
      return &device;
  }
  return nullptr;
}

/// The signals of a run that an expectation is about, as far as they are known beforehand; those of events are not.
std::vector<std::string> signals_like(const Expectation& expectation, const Scenario& scenario) {
  if (expectation.signal.find('*') == std::string::npos) return {expectation.signal};
  std::vector<std::string> signals;
  const auto offer = [&](std::string signal) {
    if (matches(expectation.signal, signal) && has_metric(signal, expectation.metric)) signals.push_back(std::move(signal));
  };
  for (const StrategyKind strategy : scenario.strategies) {
    for (const DeviceSpec& device : scenario.devices) {
      for (const char* const of : {"interaction", "force", "buffers"})
        offer(fmt::format("{}.{}.{}", device.name, of, name_of(strategy)));
      offer(fmt::format("closed_loop.{}.{}", device.name, name_of(strategy)));
    }
    offer(fmt::format("solver.{}", name_of(strategy)));
  }
  return signals;
}

}  // namespace

namespace {

/// Why nobody can be sure of a rate of these signals; empty if one can.
std::string why_not_sure(const Expectation& expectation, const Scenario& scenario) {
  if (!expectation.confidence || scenario.timing.trace.empty()) return {};
  const std::vector<std::string> signals = signals_like(expectation, scenario);
  for (const internal::RateSignal& one : internal::rate_signals(scenario)) {
    if (std::find(signals.begin(), signals.end(), one.name) == signals.end()) continue;
    const internal::RateBasis basis = internal::rate_basis(scenario, one.kind);
    if (!basis.refused.empty()) return "nobody can be sure of a rate: " + basis.refused;
  }
  return {};
}

}  // namespace

std::vector<Diagnostic> check_expectations(const Scenario& scenario) {
  std::vector<Diagnostic> errors;
  const Nominal nominal = nominal_of(scenario);
  for (const Expectation* condition : conditions_of(scenario)) {
    const Expectation& expectation = *condition;
    const auto error = [&](const Place& place, std::string message) {
      errors.push_back({place.file, place.line, place.column, std::move(message)});
    };
    const auto& at = expectation.written;
    const std::optional<std::vector<std::string>> known = metrics_of_signal(expectation.signal);
    if (!known) {
      error(at.signal, fmt::format("unknown signal '{}'", expectation.signal));
      continue;
    }
    if (std::find(known->begin(), known->end(), expectation.metric) == known->end()) {
      error(at.metric, fmt::format("unknown metric '{}' for signal '{}'{}", expectation.metric, expectation.signal,
                                   internal::suggestion(expectation.metric, {known->begin(), known->end()})));
      continue;
    }
    if (is_recovery(expectation.metric) && scenario.faults.empty() && !scenario.has_faults_off) {
      error(at.metric, fmt::format("'{}' has no value here: no fault is programmed, so there is nothing to recover from; "
                                   "docs/timings/recovery.md says what a fault is",
                                   expectation.metric));
      continue;
    }
    if (const DeviceSpec* device = without_newtons(scenario, expectation.signal)) {
      const std::string_view driver = std::visit([](const auto& spec) { return spec.kName; }, device->driver);
      error(at.signal, fmt::format("'{}' is in newtons, and driver = \"{}\" knows none; write full_scale (of a wheel: "
                                   "torque) in {} = {{ ... }} of device \"{}\"",
                                   expectation.signal, driver, driver, device->name));
      continue;
    }
    if (compares_with_twin(expectation.metric) && has_hand(scenario)) {
      error(at.metric,
            fmt::format(
                "'{}' has no value here: the twin reads the programmed motion, and a hand that feels the force has none",
                expectation.metric));
      continue;
    }
    if (std::string why = why_not_sure(expectation, scenario); !why.empty()) {
      error(at.metric, std::move(why));
      continue;
    }
    for (const auto& [limit, place] : {std::pair(expectation.min, at.min), std::pair(expectation.max, at.max)}) {
      if (!limit) continue;
      Result<double> value = 0.0;
      std::string judged;
      for (const std::string& signal : signals_like(expectation, scenario)) {
        value = base_limit(*limit, expectation, signal, scenario, nominal);
        judged = signal;
        if (!value) break;
      }
      if (value) continue;
      const bool is_count = base_unit(judged, expectation.metric) == "count";
      error(place, is_count ? fmt::format("'{}' is a count; write the number alone, {}, without '{}'", expectation.metric,
                                          limit->number, limit->unit)
                            : value.error());
      break;  // `equals` is both limits
    }
  }
  if (errors.empty()) errors = internal::lacking_for_expectations(scenario);
  return errors;
}

}  // namespace evenstep
