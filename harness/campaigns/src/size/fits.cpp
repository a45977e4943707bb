#include "fits.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <charconv>
#include <utility>

#include "clauses.h"

namespace evenstep {
namespace {

std::string read_rings(std::string_view text, SizeFits& has) {
  RingSizes rings;
  const std::size_t space = std::min(text.find(' '), text.size());
  const auto entries = [](std::string_view word, std::size_t& into) {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), into);
    return error == std::errc{} && end == word.data() + word.size() && into >= kLeastRing && into <= kMostRing;
  };
  if (!entries(text.substr(0, space), rings.samples) || !entries(internal::trimmed(text.substr(space)), rings.forces))
    return fmt::format(
        "\"rings {}\": the entries of the ring of samples and of that of forces must follow, such as "
        "\"rings 64 32\", {} to {} of each",
        text, kLeastRing, kMostRing);
  has.rings = rings;
  return {};
}

std::string read_time(std::string_view word, std::string_view text, bool may_be_negative, std::optional<Duration>& into) {
  const Result<Duration> time = parse_duration(text);
  if (!time) return fmt::format("\"{} {}\": {}", word, text, time.error());
  if (time->ns < 0 && !may_be_negative) return fmt::format("\"{} {}\": must not be below 0 s", word, text);
  into = *time;
  return {};
}

/// For what it has to be enough.
constexpr std::pair<std::string_view, std::string SizeFits::*> kFor[] = {
    {"rate", &SizeFits::rate}, {"per", &SizeFits::per}, {"confidence", &SizeFits::confidence}};

std::string not_a_clause(std::string_view clause) {
  return fmt::format(
      "\"{}\" is none of \"latency 20 ms\", \"lead 2 ms\", \"rings 64 32\", \"map clocked\", \"rate 0.1 %\", \"per 1 h\" "
      "and "
      "\"confidence 95 %\"",
      clause);
}

const SizeStrategy* strategy_of(const SizeRecord& record, const SizeFits& has) {
  if (!has.map) return strategy_to_use(record);
  const auto found = std::find_if(record.strategies.begin(), record.strategies.end(),
                                  [&](const SizeStrategy& one) { return one.name == *has.map; });
  return found == record.strategies.end() ? nullptr : &*found;
}

}  // namespace

Result<SizeFits> parse_fits(std::string_view text) {
  SizeFits has;
  const std::string error =
      internal::each_clause(text, [&](std::string_view clause, std::string_view word, std::string_view rest) -> std::string {
        if (word == "latency") return read_time(word, rest, false, has.latency);
        if (word == "lead") return read_time(word, rest, true, has.lead);
        if (word == "rings") return read_rings(rest, has);
        if (rest.empty()) return not_a_clause(clause);
        if (word == "map") return has.map = std::string(rest), "";
        for (const auto& [name, into] : kFor) {
          if (word == name) return has.*into = rest, "";
        }
        return not_a_clause(clause);
      });
  if (!error.empty()) return Failure(error);
  if (!has.latency && !has.lead && !has.rings) return Failure("it says no latency, lead or rings that could fit");
  return has;
}

SizeFit internal::fit_of(const SizeFits& has, const SizeRecord& record, const MapSetup& setup,
                         std::span<const SegmentTiming> segments) {
  SizeFit fit;
  fit.latency = has.latency;
  fit.lead = has.lead;
  const SizeStrategy* const map = strategy_of(record, has);
  if (map == nullptr || map->any_phase.culprit.step < 0) {
    std::vector<std::string> names;
    for (const SizeStrategy& one : record.strategies) names.push_back(one.name);
    fit.refused = has.map && map == nullptr
                      ? fmt::format("map '{}' was not sized, but {}", *has.map, fmt::join(names, ", "))
                      : "a map has slots once it has seen a whole segment, and this timing has none; record more";
    return fit;
  }
  fit.map = map->name;
  fit.needed_lead = map->lead;
  Duration least = map->any_phase.latency;
  if (map->per) {  // for a span of time, with the confidence asked for
    fit.unknown = map->per->refused;
    if (map->per->to_record.ns > 0)
      fit.unknown += fmt::format("; {:.6g} s more of it would do", seconds(map->per->to_record));
    fit.needed_lead = map->per->lead;
    least = map->per->latency;
  } else if (map->rate) {  // but for the share of the segments that may underrun
    fit.needed_lead = map->rate->any_phase.lead;
    least = map->rate->any_phase.latency;
  }
  if (!fit.unknown.empty()) return fit;
  // The least latency is max(E - slot) + c, so another lead changes it by the same amount.
  const Duration lead = has.lead.value_or(fit.needed_lead);
  fit.needed_latency = least + (std::max(lead, fit.needed_lead) - fit.needed_lead);
  if (!has.rings) return fit;
  fit.samples = static_cast<std::int64_t>(has.rings->samples);
  fit.forces = static_cast<std::int64_t>(has.rings->forces);
  RunningCapacities rings(setup.grids, std::max(lead, fit.needed_lead), has.latency.value_or(fit.needed_latency));
  each_mapped_step(setup, strategy_named(map->name)->kind, segments,
                   [&](std::span<const MappedStep> steps) { rings.add(steps); });
  const LatencyBudget needed = rings.budget();
  fit.needed_samples = static_cast<std::int64_t>(needed.interaction_capacity);
  fit.needed_forces = static_cast<std::int64_t>(needed.force_capacity);
  return fit;
}

RunOutcome fit_outcome(const SizeRecord& record) {
  using Verdict = ExpectationResult::Verdict;
  const SizeFit& fit = *record.fit;
  const bool known = fit.unknown.empty();
  RunOutcome outcome;
  outcome.record.file = record.input;
  outcome.record.clock = "virtual";
  const std::string signal = "sizing.buffers." + fit.map;
  const auto add = [&](const char* metric, std::optional<double> has, double needed, const char* unit, double unit_size) {
    if (known) outcome.metrics[signal][metric] = needed * unit_size;
    if (!has) return;
    ExpectationResult result;
    result.file = record.input;
    result.signal = result.pattern = signal;
    result.metric = metric;
    result.unit = unit;
    result.max = has;
    if (known) result.value = needed;
    result.detail = fit.unknown;
    result.verdict = !known ? Verdict::error : needed <= *has ? Verdict::pass : Verdict::fail;
    outcome.results.push_back(std::move(result));
  };
  const auto time = [&](const char* metric, const std::optional<Duration>& has, Duration needed) {
    const auto in_ms = [](Duration one) { return static_cast<double>(one.ns) / 1e6; };
    add(metric, has ? std::optional(in_ms(*has)) : std::nullopt, in_ms(needed), "ms", 1e-3);
  };
  time("latency", fit.latency, fit.needed_latency);
  time("lead", fit.lead, fit.needed_lead);
  const auto ring = [&](const char* metric, const std::optional<std::int64_t>& has, std::int64_t needed) {
    if (has) add(metric, static_cast<double>(*has), static_cast<double>(needed), "", 1);
  };
  ring("interaction_capacity", fit.samples, fit.needed_samples);
  ring("force_capacity", fit.forces, fit.needed_forces);
  outcome.verdict = fit.fits() ? RunVerdict::pass : known ? RunVerdict::fail : RunVerdict::error;
  return outcome;
}

}  // namespace evenstep
