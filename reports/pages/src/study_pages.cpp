#include <fmt/format.h>

#include "evenstep/pages/campaign_pages.h"
#include "evenstep/pages/page.h"

namespace evenstep {
namespace {

Html picture(const std::string& svg) {
  return svg.empty() ? Html() : element("figure", {{"class", "paper"}}, Html::markup(svg));
}
Html lines(const std::string& text) { return element("pre", {{"class", "wide"}, {"tabindex", "0"}}, text); }
Html from(const std::string& file) { return element("p", {{"class", "quiet"}}, element("code", file)); }
Html interrupted_note(bool interrupted) {
  return interrupted ? element("p", element("strong", "Interrupted: ") + "what was not measured is missing.") : Html();
}
Html machine(const std::string& version, const std::string& machine, const std::string& compiler, std::int64_t cpus,
             double load) {
  return facts({{"evenstep", version},
                {"machine", machine},
                {"processors", cpus == 0 ? "of each: see its machine" : fmt::format("{}", cpus)},
                {"load when it began", fmt::format("{:.2f}", load)},
                {"compiler", compiler}});
}

}  // namespace

std::string study_page(const StudyRecord& study, const std::string& reproduce) {
  Html figures;
  for (const StudyQuantity quantity : kStudyQuantities) figures += picture(study_svg(study, quantity));
  Page page{study.scenario, "evenstep study", "", {}, reproduce, {}, ""};
  page.summary = element("p", fmt::format("What {} particles cost and how wrong they are, over {:.3g} s; {} cells.",
                                          study.particles, study.duration_s, study.cells.size())) +
                 interrupted_note(study.interrupted) + from(study.file);
  page.sections = {
      {"cost", "Error against cost", figures},
      {"table", "Numbers", lines(study_table(study))},
      {"environment", "Environment", machine(study.version, study.machine, study.compiler, study.cpus, study.load)}};
  return html_of(page);
}

std::string felt_study_page(const FeltStudyRecord& study, const std::string& reproduce) {
  Page page{study.scenario, "evenstep study", "", {}, reproduce, {}, ""};
  page.summary =
      element("p",
              "How wrong the force is that the hand feels, what that costs, and whether the step, the remap or the "
              "device is to blame.") +
      interrupted_note(study.interrupted) + from(study.file);
  page.sections = {
      {"cost", "Error against cost", picture(felt_study_svg(study))},
      {"table", "Numbers", lines(felt_study_table(study))},
      {"environment", "Environment", machine(study.version, study.machine, study.compiler, study.cpus, study.load)}};
  return html_of(page);
}

std::string stiffness_page(const StiffnessLimits& study, const std::string& reproduce) {
  std::vector<std::vector<Html>> rows;
  for (const StiffnessLimit& limit : study.limits) {
    const bool below = limit.state == StiffnessLimit::State::below, above = limit.state == StiffnessLimit::State::above;
    rows.push_back({element("code", limit.strategy), name_of(limit.state),
                    below ? Html() : fmt::format("{:.5g}", limit.stable_N_per_m),
                    above ? Html() : fmt::format("{:.5g}", limit.unstable_N_per_m),
                    fmt::format("{:.6g}", 1e3 * limit.latency_s), fmt::format("{}", limit.runs)});
  }
  Page page{study.scenario, "evenstep study", "", {}, reproduce, {}, ""};
  page.summary = element("p", "The largest stiffness that stays stable in a hand that feels the force.") +
                 interrupted_note(study.interrupted) + from(study.file);
  page.sections = {{"limits", "Stiffness and latency",
                    table("Searched from " + fmt::format("{:.5g} to {:.5g} N/m.", study.from_N_per_m, study.to_N_per_m),
                          {{"strategy"},
                           {"state"},
                           {"stable, N/m", true},
                           {"not stable, N/m", true},
                           {"latency, ms", true},
                           {"runs", true}},
                          rows)},
                   {"environment", "Environment",
                    facts({{"evenstep", study.version}, {"seeds", fmt::format("{} from {} on", study.seeds, study.seed)}})}};
  return html_of(page);
}

std::string size_page(const SizeRecord& record, const std::string& reproduce) {
  const auto ms = [](Duration d) { return fmt::format("{:.6f}", static_cast<double>(d.ns) * 1e-6); };
  const auto row = [&](const Html& name, const SizeNeed& need, const SizeStrategy* strategy) -> std::vector<Html> {
    return {name,
            ms(need.latency),
            ms(need.windows.p50),
            ms(need.windows.p99),
            ms(need.total_delay),
            fmt::format("{:.4g}", need.stiffness_limit_N_per_m),
            strategy ? Html(ms(strategy->lead)) : Html(),
            strategy ? Html(fmt::format("{}, {}", strategy->interaction_capacity, strategy->force_capacity)) : Html()};
  };
  const SizeBounds& bounds = record.linear ? *record.linear : record.held;
  std::vector<std::vector<Html>> rows{row("taut string", bounds.taut_string, nullptr),
                                      row("best line", bounds.best_line, nullptr)};
  for (const SizeStrategy& strategy : record.strategies)
    rows.push_back(row(element("code", strategy.name), strategy.any_phase, &strategy));
  Page page{record.input, "evenstep size", "", {}, reproduce, {}, ""};
  page.summary = element("p", fmt::format("{} steps in {} segments, {:.6g} s; forces {}.", record.steps, record.segments,
                                          seconds(record.length), record.interpolated ? "interpolated" : "held"));
  page.sections = {{"latency", "Least latency",
                    table("The least latency for which nothing underruns, at any phase of the device, and what it costs. No "
                          "scheme of constant latency does with less than the taut string.",
                          {{""},
                           {"latency, ms", true},
                           {"windows p50, ms", true},
                           {"p99, ms", true},
                           {"total delay, ms", true},
                           {"stiffness limit, N/m", true},
                           {"lead, ms", true},
                           {"samples, forces kept", true}},
                          rows)},
                   {"jump", "Latency against evenness", picture(size_svg(record))},
                   {"words", "In words", lines(size_text(record))}};
  return html_of(page);
}

std::string advice_page(const AdviceRecord& record, const std::string& reproduce) {
  Page page{record.input, "evenstep advise", "", {}, reproduce, {}, ""};
  page.summary =
      element("p", fmt::format("{} steps in {} segments, {:.6g} s.", record.steps, record.segments, seconds(record.length)));
  for (const std::string& line : advice_conclusion(record)) page.summary += element("p", line);
  page.sections = {{"choices", "What each choice costs", picture(advice_svg(record))},
                   {"words", "In words", lines(advice_text(record))}};
  return html_of(page);
}

}  // namespace evenstep
