#include "evenstep/pages/run_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "evenstep/pages/page.h"
#include "evenstep/reports/figures.h"
#include "evenstep/reports/pause_parts.h"
#include "evenstep/reports/saturation.h"
#include "evenstep/reports/writers.h"
#include "src/expectations.h"
#include "src/run_charts.h"

namespace evenstep {
namespace {

using internal::line_id;

std::string ms(Duration duration) { return fmt::format("{:.6g} ms", static_cast<double>(duration.ns) * 1e-6); }
std::string number(double value) { return fmt::format("{:.4g}", value); }

Html paragraph(const Html& text) { return element("p", text); }
Html note(const Html& text) { return element("p", {{"class", "note"}}, text); }

/// Where report.js puts a chart.
Html chart(std::string_view name, const Html& caption) {
  return element("figure", {{"class", "chart"}, {"data-chart", name}}, element("figcaption", caption));
}

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// "3 of 14 expectations fail" in words that a meeting understands.
Html sentence_of(const RunPage& page) {
  std::map<ExpectationResult::Verdict, std::size_t> tally;
  for (const ExpectationResult& result : page.results) ++tally[result.verdict];
  using Verdict = ExpectationResult::Verdict;
  const std::size_t all = page.results.size() - tally[Verdict::skipped];
  if (!page.failure.empty()) return {};
  if (all == 0) return "Nothing was asserted, so this is no verdict: the scenario has no expectation that was judged.";
  std::string text;
  for (const auto& [verdict, verb] : {std::pair(Verdict::error, "could not be judged"), std::pair(Verdict::fail, "failed"),
                                      std::pair(Verdict::degraded, "did not hold because the machine was too slow")}) {
    if (tally[verdict] > 0)
      text += fmt::format("{}{} of {} {}", text.empty() ? "" : "; ", tally[verdict], counted(all, "expectation"), verb);
  }
  return text.empty()
             ? Html(fmt::format("{} held.", all == 1 ? "The one expectation" : fmt::format("All {} expectations", all)))
             : Html(text + ".");
}

Html summary_of(const RunPage& page) {
  Html text;
  if (const Html sentence = sentence_of(page); !sentence.empty()) text += paragraph(sentence);
  if (!page.failure.empty()) text += element("p", {{"class", "stopped"}}, element("strong", "Stopped: ") + page.failure);
  for (const std::string& one : page.suffered) text += paragraph(element("strong", "Went wrong: ") + one);
  if (!page.remedy.empty()) text += paragraph(element("strong", "Remedy: ") + page.remedy);
  return text +
         element("p", {{"class", "quiet"}},
                 element("code", page.run.file) + fmt::format(", seed {}, {} clock, {}", page.run.seed, page.run.clock,
                                                              page.run.clock == "wall" ? "live" : "simulated"));
}

/// The figures as pictures, for readers without scripts.
Html still_figures(const RunPage& page) {
  std::string pictures;
  for (const Nominal::Device& device : page.run.nominal.devices) {
    pictures += figure_1a_svg(page.run, device.name, page.results) + figure_1b_svg(page.run, device.name, page.results);
    constexpr std::size_t kMost = 150'000;  // bytes
    if (pictures.size() > kMost) break;
  }
  return element("noscript", element("figure", {{"class", "paper"}}, Html::markup(std::move(pictures))));
}

Html figure_1(const RunPage& page) {
  return element("div", {{"class", "controls"}, {"data-controls", "figure-1"}}) +
         chart("interaction",
               "Figure 1 a: the hand as the physics sees it, in simulation time. Evenly moving hands should give a straight "
               "line; a saw-tooth means that the physics sees jumps.") +
         chart("interaction-off",
               "Off the fitted line, in steps: for each strategy a straight line is fitted (least squares) to what is shown "
               "of "
               "its curve above, and this is what is left. 0 is perfectly even; 1 is what the hand moves in one step. While "
               "the hand turns, no line fits and this says nothing.") +
         chart("force", "Figure 1 b: the force at the device's ticks, in real time. It should follow without bursts.") +
         chart("force-off", "Off the fitted line: the same for the force.") +
         note(
             "Drag across a chart to zoom, double-click or press Esc to see all; the charts move together. Keys: + and − "
             "zoom, "
             "← and → move.") +
         still_figures(page);
}

/// What the tissue looked like, and what was done on a wall clock while the steps waited.
Html tissue(const RunPage& page) {
  Html body;
  for (const StrategyRecord& strategy : page.run.strategies) {
    if (strategy.tissue.svg.empty()) continue;
    body += element("figure", {{"class", "paper"}},
                    Html::markup(strategy.tissue.svg) +
                        element("figcaption", element("code", strategy.name) + (": " + strategy.tissue.caption)));
  }
  if (!page.run.visualization.empty()) body += note("In the time of a visualization: " + page.run.visualization + ".");
  return body;
}

Html stepper() {
  return element("div", {{"class", "controls"}, {"data-controls", "stepper"}}) +
         element(
             "figure", {{"class", "chart"}, {"data-stepper", ""}, {"tabindex", "0"}},
             element("figcaption",
                     "Figures 2 to 4 for one segment. From top to bottom: the hand as sampled, and as a step reads it; the "
                     "slots; the steps as they ran, with the visualization; when each force is due; the forces sent. Lines "
                     "join a step to its slot and to its force. Keys: ← and → step, Home and End jump."));
}

/// What the pause consists of that the latency has to bridge: of the live strategy, or of the first one.
Html pause(const RunPage& page) {
  const auto& all = page.run.strategies;
  if (all.empty()) return {};
  const auto live = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == page.run.live; });
  const std::string parts = text(longest_pause(live == all.end() ? all.front() : *live));
  return parts.empty() ? Html() : paragraph(parts);
}

Html latency_table(const RunPage& page) {
  std::vector<std::vector<Html>> rows;
  for (const StrategyRecord& strategy : page.run.strategies) {
    const LatencyRecord& latency = strategy.latency;
    if (strategy.reference) continue;
    if (latency.latency.ns == 0 && latency.least_any_phase.ns == 0) continue;
    rows.push_back({element("code", strategy.name), ms(latency.lead),
                    ms(latency.latency) + (latency.adapts ? " at most" : ""), ms(latency.least_any_phase), latency.trusted,
                    ms(latency.least_this_phase),
                    latency.latency_culprit >= 0 ? fmt::format("{}", latency.latency_culprit) : "",
                    fmt::format("{}, {}", latency.interaction_capacity, latency.force_capacity)});
  }
  if (rows.empty()) return {};
  return table("Latency: from the instant that a step answers to the emission of its force.",
               {{"strategy"},
                {"lead", true},
                {"latency", true},
                {"least at any phase", true},
                {"for an hour, 95 % sure"},
                {"least at this phase", true},
                {"step that sets it", true},
                {"samples, forces kept", true}},
               rows);
}

std::string shown(const std::optional<double>& value) { return value ? number(*value) : ""; }

Html stiffness_table(const RunPage& page) {
  std::vector<std::vector<Html>> rows;
  for (const StrategyRecord& strategy : page.run.strategies) {
    for (const DeviceRecord& device : strategy.devices) {
      const LoopRecord& loop = device.loop;
      if (!loop.stiffness_N_per_m && !loop.stiffness_limit_N_per_m) continue;
      rows.push_back({element("code", strategy.name), device.name, fmt::format("{:.6g} ms", 1e3 * loop.delay_s),
                      shown(loop.stiffness_N_per_m), shown(loop.stiffness_limit_N_per_m), shown(loop.alpha),
                      shown(loop.alpha_star)});
    }
  }
  if (rows.empty()) return {};
  return table("Stiffness: what the hand feels at rest, and the most that this delay allows where a hand feels the force.",
               {{"strategy"},
                {"device"},
                {"delay", true},
                {"felt, N/m", true},
                {"limit, N/m", true},
                {"local model, alpha", true},
                {"alpha*", true}},
               rows);
}

/// "p50 0.05 ms" and the like, of the metrics of device ticks.
Html lateness(const RunPage& page) {
  if (page.run.live.empty()) return {};
  const std::string lines = live_lines(page.run, page.metrics);
  Html body = element("pre", {{"class", "wide"}}, lines);
  if (!page.run.real_time_granted)
    body += paragraph("The system refused real-time scheduling (SCHED_FIFO), so this lateness is the kernel's.");
  return body + chart("lateness", "How late each device tick was, over the run.");
}

Html left_out(const RunPage& page) {
  Html items;
  for (const std::string& what : page.run.left_out) items += element("li", what);
  if (!page.run.strategies.empty()) {
    for (const std::string& what : page.run.strategies.front().solver.lacks)
      items += element("li", "the solver lacks " + what + ": what needs it was not judged");
  }
  for (const ExpectationResult& result : page.results) {
    if (result.verdict == ExpectationResult::Verdict::skipped)
      items += element("li", Html("not judged under this clock: ") + element("code", result.signal) + (" " + result.metric));
  }
  if (items.empty()) return {};
  return paragraph("Features that the scene does not need are not computed, and what could not be judged was not.") +
         element("ul", items);
}

Html environment(const RunPage& page) {
  std::vector<std::pair<std::string, Html>> pairs{
      {"evenstep", page.version},
      {"clock", page.run.clock},
      {"seed", fmt::format("{}", page.run.seed)},
      {"trace hash", element("code", fmt::format("{:016x}", page.run.trace_hash))},
      {"live strategy", page.run.live}};
  if (!page.run.strategies.empty()) {
    const SolverRecord& solver = page.run.strategies.front().solver;
    pairs.emplace_back("solver", solver.name);
    pairs.emplace_back("solver's device", solver.device);
    pairs.emplace_back("method", fmt::format("{}, {} per step", solver.method,
                                             counted(static_cast<std::size_t>(solver.substeps), "substep")));
    if (solver.particles > 0) pairs.emplace_back("particles", fmt::format("{}", solver.particles));
    if (solver.step_limit_s > 0) pairs.emplace_back("step limit", fmt::format("{:.4g} ms", 1e3 * solver.step_limit_s));
  }
  std::vector<std::vector<Html>> rows;
  for (const StrategyRecord& strategy : page.run.strategies)
    rows.push_back({element("code", strategy.name), fmt::format("{}", strategy.steps.size()),
                    fmt::format("{}", strategy.segments.size()),
                    element("code", fmt::format("{:016x}", strategy.trace_hash)),
                    strategy.interrupted ? "interrupted"
                    : strategy.shadow    ? "shadow of the live run"
                                         : ""});
  Html body = facts(pairs);
  if (!rows.empty())
    body += table("Strategies: the same scenario and seed give the same hash anywhere.",
                  {{"strategy"}, {"steps", true}, {"segments", true}, {"trace hash"}, {""}}, rows);
  return body;
}

Html saturated(const RunPage& page) {
  Html items;
  for (const auto& [signal, saturation] : saturations(page.run))
    items += element("li", element("code", signal) + (": " + text(saturation)));
  if (items.empty()) return {};
  return element("h3", "Signals that met a limit") +
         paragraph("A force at its limit is smooth whatever drives it, so the shape of these signals is not judged.") +
         element("ul", items);
}

Html source_of(const SourceText& source, std::span<const ExpectationResult> results) {
  std::map<std::int64_t, Html> why;
  for (const ExpectationResult& result : results) {
    if (result.file == source.file && result.verdict > ExpectationResult::Verdict::pass)
      why[result.line] += element("span", {{"class", "why"}}, failure_message(result));
  }
  Html lines;
  std::string_view rest = source.text;
  for (std::int64_t line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const auto failed = why.find(line);
    const Html text = rest.substr(0, end > 0 && rest[end - 1] == '\r' ? end - 1 : end);
    lines += failed == why.end()
                 ? element("li", {{"id", line_id(source.file, line)}}, text)
                 : element("li", {{"id", line_id(source.file, line)}, {"class", "failed"}}, text + failed->second);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return element("h3", element("code", source.file)) +
         element("div", {{"class", "source"}, {"tabindex", "0"}, {"role", "region"}, {"aria-label", source.file}},
                 element("ol", lines));
}

Html sources(const RunPage& page) {
  Html body;
  for (const SourceText& source : page.sources) body += source_of(source, page.results);
  return body;
}

Html case_section(const RunPage& page) {
  if (!page.case_record) return {};
  return element("figure", {{"class", "paper"}}, Html::markup(case_strip_svg(*page.case_record, page.run.scenario))) +
         element("pre", {{"class", "wide"}, {"tabindex", "0"}}, case_table(*page.case_record));
}

}  // namespace

std::string run_page(const RunPage& page) {
  const Json charts = internal::run_charts(page.run, page.results);
  const bool drawn = !charts.is_null();
  const bool schedule =
      drawn && std::any_of(page.run.strategies.begin(), page.run.strategies.end(), [](const auto& strategy) {
        return std::any_of(strategy.steps.begin(), strategy.steps.end(), [](const StepRow& s) { return s.mapped; });
      });
  Page out;
  out.title = page.run.scenario.empty() ? page.run.file : page.run.scenario;
  out.kind = page.run.clock == "wall" ? "evenstep live run" : "evenstep run";
  out.verdict = page.verdict;
  out.summary = summary_of(page);
  out.command = page.reproduce;
  out.sections = {
      {"expectations", "Expectations", internal::expectations_table(page.results, page.run.file) + saturated(page)},
      {"cells", "Cells", case_section(page)},
      {"figure-1", "Motion and force", drawn ? figure_1(page) : Html()},
      {"tissue", "Tissue", tissue(page)},
      {"segment", "One segment", drawn ? stepper() : Html()},
      {"staircase", "Staircase",
       drawn ? chart("staircase",
                     "Simulation time of each step: when it began to be computed (a staircase: it waits while the simulator "
                     "draws), and the instant of the hand that it reads, which should be a straight line.")
             : Html()},
      {"occupancy", "Buffers",
       schedule
           ? chart("waiting",
                   "Forces that wait in the schedule when a step ends. The dashed line is how many it has room for.") +
                 chart("spare",
                       "Time that is left until a step's force is due, when the step ends. Below 0 the force is late.") +
                 chart("age",
                       "How old the hand's position is that a step reads, when the step begins. Below 0 it does not "
                       "exist yet.")
           : Html()},
      {"error", "Error over the run",
       drawn ? element("div", {{"class", "controls"}, {"data-controls", "bins"}}) +
                   chart("bins", "The error in each part of the run, logarithmic. A line that rises means that it grows.") +
                   chart("underruns", "Underruns so far.")
             : Html()},
      {"cost", "Error against cost",
       page.study_svg.empty() ? Html() : element("figure", {{"class", "paper"}}, Html::markup(page.study_svg))},
      {"lateness", "Lateness", lateness(page)},
      {"latency", "Latency and stiffness", latency_table(page) + pause(page) + stiffness_table(page)},
      {"left-out", "Left out", left_out(page)},
      {"environment", "Environment", environment(page)},
      {"scenario", "Scenario", sources(page)}};
  if (drawn) out.charts = json_text(charts);
  return html_of(out);
}

}  // namespace evenstep
