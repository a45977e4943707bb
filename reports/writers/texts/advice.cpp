#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "evenstep/reports/advice_record.h"
#include "size_conclusion.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

using internal::ms;

constexpr double kNoJump = 1e-3;  // steps; times are whole nanoseconds, so even steps jump by a millionth at most

std::string stiffness(double N_per_m) {
  return N_per_m < 100 ? fmt::format("{:.3g}", N_per_m) : fmt::format("{:.0f}", N_per_m);
}

std::string list_of(const std::vector<int>& numbers) {
  std::string out;
  for (const int number : numbers) out += fmt::format("{}{}", out.empty() ? "" : ", ", number);
  return out;
}

/// The last column: why a choice is not on the front, and which are as good as it.
std::string standing(const AdviceChoice& choice) {
  if (!choice.failure.empty()) return choice.failure;
  if (!choice.ranked) return fmt::format("its hand shakes with {} N/m", stiffness(choice.tried_N_per_m));
  if (!choice.on_front) {
    std::vector<int> some = choice.dominated_by;
    constexpr std::size_t kMost = 4;
    const bool more = some.size() > kMost;
    some.resize(std::min(some.size(), kMost));
    return "beaten by " + list_of(some) + (more ? " ..." : "");
  }
  return choice.ties.empty() ? "" : "as good as " + list_of(choice.ties);
}

std::string jump(double steps) { return steps < kNoJump ? "<0.001" : fmt::format("{:.2g}", steps); }

std::string row(const AdviceChoice& choice, std::size_t width) {
  std::string out = fmt::format("{} {:>3}  {:<{}}", choice.on_front ? '*' : ' ', choice.number, name_of(choice), width);
  if (!choice.failure.empty()) return out + " " + choice.failure + "\n";
  const std::string latency = choice.map != "direct" ? fmt::format("{:.3f}", ms(choice.latency)) : "-";
  const std::string bound = choice.bound ? fmt::format("{:.3f}", ms(*choice.bound)) : "-";
  const double lost = 100 * std::max(choice.drawings_lost, choice.simulated_lost);
  return out + fmt::format(" {:>9} {:>9} {:>9.2f} {:>8} {:>8} {:>8.3g} {:>7.3g} {:>7.3g} {:>7}  {}\n", latency, bound,
                           1e3 * choice.delay_s, jump(choice.jump_step), jump(choice.force_jump_step),
                           1e3 * choice.runs_on_s, 100 * late_share(choice), lost, stiffness(choice.stiffness_N_per_m),
                           standing(choice));
}

const AdviceChoice* least_delay(const AdviceRecord& record, bool (*admits)(const AdviceChoice&)) {
  const AdviceChoice* least = nullptr;
  for (const AdviceChoice& choice : record.choices) {
    if (choice.on_front && admits(choice) && (least == nullptr || choice.delay_s < least->delay_s)) least = &choice;
  }
  return least;
}

std::string what_it_gives(const AdviceChoice& choice) {
  return fmt::format("{:.4g} ms from hand to force, jumps of {} steps, {} N/m", 1e3 * choice.delay_s, jump(choice.jump_step),
                     stiffness(choice.stiffness_N_per_m));
}

std::string sentence(const char* when, const AdviceChoice& choice) {
  return fmt::format("{}: {} ({}): {}.", when, choice.number, name_of(choice), what_it_gives(choice));
}

}  // namespace

std::vector<std::string> advice_conclusion(const AdviceRecord& record) {
  const AdviceChoice* const with = choice_to_use(record, true);
  const AdviceChoice* const without = choice_to_use(record, false);
  if (with == nullptr && without == nullptr)
    return {
        "Nothing can be advised: no choice without late forces came to rest in a hand. Take away what hitches "
        "(evenstep size says which), or record more."};
  std::vector<std::string> out;
  const AdviceChoice* const spread = least_delay(record, [](const AdviceChoice& one) { return one.governor == "spread"; });
  const AdviceChoice* const base = without != nullptr ? without : with;
  if (spread != nullptr && spread->delay_s < base->delay_s)
    out.push_back(
        fmt::format("{} Nothing is dropped, drawings begin up to {:.3g} ms later, {:.3g} % of the simulated time are lost; "
                    "whether a device that rests between steps gets slower, evenstep record --spread measures.",
                    sentence("First of all, let each step wait for its slot", *spread), ms(spread->drawings_later),
                    100 * spread->simulated_lost));
  if (with != nullptr) out.push_back(sentence("If the solver says how stiff the contact is", *with));
  if (without != nullptr)
    out.push_back(sentence("If it gives forces only", *without) +
                  (without->unseen ? " " + evenstep::text(*without->unseen) : ""));
  const AdviceChoice* const springs = least_delay(
      record, [](const AdviceChoice& one) { return one.needs_springs && one.governor.empty() && one.map != "direct"; });
  if (springs != nullptr && with != nullptr && springs->stiffness_N_per_m > with->stiffness_N_per_m)
    out.push_back(sentence("If the device renders springs by itself, and stiff contacts matter", *springs));
  const AdviceChoice* const late =
      least_delay(record, [](const AdviceChoice& one) { return one.accepted_rate > 0 && one.governor.empty(); });
  if (late != nullptr && late->delay_s < base->delay_s)
    out.push_back(fmt::format("{} It is late in {:.3g} % of the segments.",
                              sentence("If a force may be late now and then", *late), 100 * late_share(*late)));
  const AdviceChoice* const rougher = least_delay(record, [](const AdviceChoice& one) { return one.allowed_jump > 0; });
  if (rougher != nullptr && rougher->delay_s < base->delay_s)
    out.push_back(sentence("If nobody feels a larger jump", *rougher));
  const AdviceChoice* const adaptive = least_delay(record, [](const AdviceChoice& one) { return one.adaptive; });
  if (adaptive != nullptr && adaptive->delay_s < base->delay_s)
    out.push_back(
        fmt::format("{} It is late in {:.3g} % of the segments, and carries what {:.4g} ms do, the most that it may become.",
                    sentence("If the latency may follow what the steps need", *adaptive), 100 * late_share(*adaptive),
                    ms(*adaptive->latency_most)));
  const AdviceChoice* const predicted = least_delay(record, [](const AdviceChoice& one) { return one.map == "predict"; });
  if (predicted != nullptr)
    out.push_back(fmt::format("{} At a stop it runs on by {:.3g} ms of the hand's way.",
                              sentence("If the hand never stops or turns suddenly", *predicted),
                              1e3 * predicted->runs_on_s));
  const AdviceChoice* const governed = least_delay(record, [](const AdviceChoice& one) { return !one.governor.empty(); });
  if (governed != nullptr && governed->delay_s < base->delay_s)
    out.push_back(fmt::format("{} It costs {:.3g} % of the drawings and {:.3g} % of the simulated time.",
                              sentence("If the simulator can be changed", *governed), 100 * governed->drawings_lost,
                              100 * governed->simulated_lost));
  const AdviceChoice* const direct = least_delay(record, [](const AdviceChoice& one) { return one.map == "direct"; });
  if (direct != nullptr) {
    const std::string hand = fmt::format("Without a map ({}, {}) the hand ", direct->number, name_of(*direct));
    out.push_back(direct->jump_step < kNoJump
                      ? hand + "does not jump: these steps are even."
                      : hand +
                            fmt::format("jumps by {:.2g} steps: only where nobody feels or sees that.", direct->jump_step));
  }
  return out;
}

std::string advice_text(const AdviceRecord& record, std::size_t columns) {
  std::string out = internal::in_lines(
      fmt::format("{}: {} steps in {} segments, {:.6g} s; device period {:.6g} ms; {:.3g} kg and {:.3g} N s/m of hand and "
                  "device",
                  record.input, record.steps, record.segments, seconds(record.length), ms(record.sampling_period),
                  record.mass_kg, record.damping_N_s_per_m),
      columns);
  out += "\n";
  std::size_t width = 0;
  for (const AdviceChoice& choice : record.choices) width = std::max(width, name_of(choice).size());
  const auto heads = [&](const char* name, const std::array<const char*, 9>& columns_of) {
    fmt::format_to(std::back_inserter(out), "{:>5}  {:<{}} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8} {:>7} {:>7} {:>7}\n", "",
                   name, width, columns_of[0], columns_of[1], columns_of[2], columns_of[3], columns_of[4], columns_of[5],
                   columns_of[6], columns_of[7], columns_of[8]);
  };
  heads("", {"latency", "bound", "delay", "jump", "force", "runs on", "late", "lost", "carries"});
  heads("choice", {"ms", "ms", "ms", "step", "step", "ms", "%", "%", "N/m"});
  for (const AdviceChoice& choice : record.choices) out += row(choice, width);
  out += "\n";
  out += internal::in_lines(
      "* Pareto-optimal: no other choice that needs no more is better in one number and as good in all others.", columns);
  if (const std::string pause = text(record.pause); !pause.empty()) out += internal::in_lines(pause, columns);
  for (const std::string& note : record.notes) out += internal::in_lines(note, columns);
  out += "\nConclusion\n";
  for (const std::string& line : advice_conclusion(record)) out += internal::in_lines(line, columns, "  ");
  return out;
}

}  // namespace evenstep
