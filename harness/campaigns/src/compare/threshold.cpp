#include "evenstep/campaigns/threshold.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "evenstep/reports/measures.h"
#include "evenstep/text/quantity.h"
#include "evenstep/text/suggest.h"
#include "evenstep/text/units.h"

namespace evenstep {
namespace {

constexpr std::string_view kMargin = "margin", kWorse = "worse";
constexpr std::string_view kExample = "for example 'latency > +5 %'";
/// Every form that a signal can have.
constexpr const char* kForms[] = {"*.interaction.*", "*.force.*",  "*.buffers.*", "closed_loop.*.*",
                                  "solver.*",        "events.*.*", "run",         "case.*.*"};

struct WrongText {
  std::size_t at;  ///< offset in the text
  std::string message;
};

std::vector<std::string_view> split(std::string_view text, char between) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(between, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

/// Whether a signal is meant by `where`: by the name of its strategy, or part by part. The signal of an expectation may have
/// a `*` of its own, and is meant if it may be about a signal that is.
bool is_at(std::string_view where, std::string_view signal) {
  const std::vector<std::string_view> wanted = split(where, '.'), parts = split(signal, '.');
  const auto meets = [](std::string_view one, std::string_view other) { return one == "*" || other == "*" || one == other; };
  if (wanted.size() == 1)
    return where == "*" || where == signal || (where != "run" && parts.size() > 1 && meets(where, parts.back()));
  return std::equal(wanted.begin(), wanted.end(), parts.begin(), parts.end(), meets);
}

/// The forms of signals that have this metric and that `where` can mean.
std::vector<std::string> forms_with(const std::string& where, const std::string& metric) {
  std::vector<std::string> forms;
  if (where.find('.') != std::string::npos || where == "run") {
    forms.push_back(where);
  } else {
    forms.assign(std::begin(kForms), std::end(kForms));
  }
  std::erase_if(forms, [&](const std::string& form) {
    const auto metrics = metrics_of_signal(form);
    return !metrics || std::find(metrics->begin(), metrics->end(), metric) == metrics->end();
  });
  return forms;
}

class Parser {
 public:
  explicit Parser(const std::string& text) : text_(text) { threshold_.text = text; }

  Threshold parse() {
    const std::size_t sign = text_.find_first_of("<>=");
    const std::vector<Word> words = words_until(sign);
    if (words.empty()) throw WrongText{0, fmt::format("expected a metric, or verdict, missing or trace; {}", kExample)};
    if (words.size() > 2)
      throw WrongText{words[2].at, fmt::format("'{}' is too much: expected at most a strategy or a signal, and a metric; {}",
                                               words[2].text, kExample)};
    if (words.size() == 2) take_where(words[0]);
    take_what(words.back());
    const bool has_change = threshold_.kind == Threshold::Kind::change || threshold_.kind == Threshold::Kind::worse;
    if (sign == std::string::npos && has_change)
      throw WrongText{text_.size(),
                      fmt::format("expected a change behind '{}': '> +5 %', '> +0.1 mm' or '< -1 %'", words.back().text)};
    if (sign != std::string::npos && !has_change)
      throw WrongText{sign, fmt::format("'{}' stands alone: leave out what follows it", words.back().text)};
    if (has_change) take_changes(sign);
    return threshold_;
  }

 private:
  struct Word {
    std::string text;
    std::size_t at;
  };

  std::vector<Word> words_until(std::size_t end) const {
    std::vector<Word> words;
    bool inside = false;
    for (std::size_t i = 0; i < std::min(end, text_.size()); ++i) {
      const bool blank = text_[i] == ' ' || text_[i] == '\t';
      if (!blank && !inside) words.push_back({"", i});
      if (!blank) words.back().text += text_[i];
      inside = !blank;
    }
    return words;
  }

  void take_where(const Word& word) {
    threshold_.where = word.text;
    const bool is_signal = word.text.find('.') != std::string::npos;
    if (is_signal && !metrics_of_signal(word.text))
      throw WrongText{word.at,
                      fmt::format("'{}' is no signal, nor a strategy; a signal is for example '*.force.phase_locked' "
                                  "(`evenstep list` shows all)",
                                  word.text)};
  }

  void take_what(const Word& word) {
    using Kind = Threshold::Kind;
    threshold_.metric = word.text;
    threshold_.kind = word.text == "verdict"   ? Kind::verdict
                      : word.text == "missing" ? Kind::missing
                      : word.text == "trace"   ? Kind::trace
                      : word.text == kWorse    ? Kind::worse
                                               : Kind::change;
    if (threshold_.kind != Kind::change || word.text == kMargin) return;
    if (!forms_with(threshold_.where, word.text).empty()) return;
    if (!threshold_.where.empty() && !forms_with("", word.text).empty())
      throw WrongText{word.at, fmt::format("'{}' is no metric of '{}'; leave '{}' out, or name a signal that has it",
                                           word.text, threshold_.where, threshold_.where)};
    throw WrongText{word.at, fmt::format("'{}' is no metric{}", word.text, near_metric(word.text))};
  }

  static std::string near_metric(const std::string& typed) {
    std::set<std::string> names{std::string(kMargin), std::string(kWorse), "verdict", "missing", "trace"};
    for (const char* const form : kForms) {
      const std::optional<std::vector<std::string>> metrics = metrics_of_signal(form);
      names.insert(metrics->begin(), metrics->end());
    }
    const std::vector<std::string_view> known(names.begin(), names.end());
    const std::string_view near = internal::nearest(typed, known);
    return near.empty() ? "; `evenstep list --json` has them all" : fmt::format("; did you mean '{}'?", near);
  }

  void take_changes(std::size_t at) {
    threshold_.grows = text_[at] == '>';
    if (threshold_.kind == Threshold::Kind::worse && !threshold_.grows)
      throw WrongText{at, "expected '> +', because 'worse' counts towards what is worse, such as 'worse > +5 %'"};
    for (;;) {
      const std::size_t end = std::min(text_.find(" and ", at), text_.size());
      take_change(at, end);
      if (end == text_.size()) return;
      at = text_.find_first_not_of(" \t", end + 5);
      if (at == std::string::npos) throw WrongText{text_.size(), "expected another change behind 'and', such as '+1 ms'"};
    }
  }

  /// One change in [at, end), with or without "> " before it.
  void take_change(std::size_t at, std::size_t end) {
    const char sign = threshold_.grows ? '+' : '-', other = threshold_.grows ? '>' : '<';
    if (text_[at] == '>' || text_[at] == '<' || text_[at] == '=') {
      if (text_[at] != other) throw WrongText{at, "expected '> +' or '< -', the same one in all parts"};
      ++at;
    }
    while (at < end && (text_[at] == ' ' || text_[at] == '\t')) ++at;
    if (at == end || text_[at] != sign) {
      throw WrongText{
          at, fmt::format("expected a change with its sign, such as '{} {}5 %'; a limit on the value itself belongs in "
                          "[[expect]] of the scenario",
                          other, sign)};
    }
    const internal::NumberAndUnit number = internal::split_number(std::string_view(text_).substr(at + 1, end - at - 1));
    const bool negative = number.number.mantissa < 0,
               fraction = number.divisor.mantissa != 1 || number.divisor.exponent != 0;
    if (!number.error.empty() || negative || fraction)
      throw WrongText{at, number.error.empty() ? "expected a decimal number with one sign" : number.error};
    Threshold::Change change{internal::to_double(number.number), std::string(number.unit)};
    if (change.unit != "%") check_unit(change.unit, at);
    threshold_.changes.push_back(std::move(change));
  }

  /// A unit other than % must be one of the metric's, wherever it is measured.
  void check_unit(const std::string& unit, std::size_t at) const {
    if (threshold_.kind == Threshold::Kind::worse)
      throw WrongText{at, "expected a change in %, because metrics of all units are meant, such as 'worse > +5 %'"};
    if (unit == "step")
      throw WrongText{at,
                      "a 'step' is another length in each scenario; write a length or a force, such as '+0.1 mm', or a "
                      "change in %"};
    if (threshold_.metric == kMargin) {
      if (unit.empty()) return;
      throw WrongText{at, fmt::format("a margin is a share of its limit; write a number such as '{}0.1', or %",
                                      threshold_.grows ? '+' : '-')};
    }
    std::string why;
    for (const std::string& form : forms_with(threshold_.where, threshold_.metric)) {
      const Result<double> factor = unit_factor(unit, base_unit(form, threshold_.metric), 0, {});
      if (factor) return;
      why = factor.error();
    }
    throw WrongText{at, why};
  }

  const std::string& text_;
  Threshold threshold_;
};

}  // namespace

std::string figure_unit(const std::string& signal, const std::string& metric) {
  if (metric == kMargin) return "1";
  return base_unit(signal, metric);
}

bool Threshold::covers(const std::string& signal, const std::string& figure_metric) const {
  if (!where.empty() && !is_at(where, signal)) return false;
  switch (kind) {
    case Kind::change:
      return figure_metric == metric && std::all_of(changes.begin(), changes.end(), [&](const Change& change) {
               return change.unit == "%" || unit_factor(change.unit, figure_unit(signal, figure_metric), 0, {}).ok();
             });
    case Kind::worse:
      return figure_metric != kMargin && better_of(signal, figure_metric) != Better::neither &&
             !is_timed(signal, figure_metric);
    case Kind::verdict:
      return figure_metric == "verdict";
    case Kind::missing:
      return figure_metric != "trace" && figure_metric != kMargin;
    case Kind::trace:
      return figure_metric == "trace";
  }
  return false;
}

bool Threshold::exceeded(const std::string& signal, const std::string& figure_metric, double a, double b,
                         bool falls_worse) const {
  const double difference = kind == Kind::worse && falls_worse ? a - b : b - a;
  const double towards = grows ? difference : -difference;
  return std::all_of(changes.begin(), changes.end(), [&](const Change& change) {
    if (towards <= 0) return false;
    if (change.unit == "%") return a == 0 || towards > change.number / 100 * std::abs(a);
    return towards > in_base({change.number, change.unit}, figure_unit(signal, figure_metric), 0, {}).value_or(0);
  });
}

Result<Threshold, Diagnostic> parse_threshold(const std::string& text) {
  try {
    return Parser(text).parse();
  } catch (const WrongText& wrong) {
    return Failure(Diagnostic{"--fail-if", 1, static_cast<std::int64_t>(wrong.at) + 1,
                              fmt::format("{}, in \"{}\"", wrong.message, text)});
  }
}

}  // namespace evenstep
