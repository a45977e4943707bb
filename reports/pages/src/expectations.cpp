#include "src/expectations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/pages/page.h"
#include "evenstep/reports/limit_text.h"
#include "evenstep/time/digest.h"

namespace evenstep::internal {
namespace {

using Verdict = ExpectationResult::Verdict;

constexpr double kWidth = 144, kHeight = 14, kLimitAt = 0.6;

std::string_view word_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::skipped:
      return "skipped";
    case Verdict::pass:
      return "pass";
    case Verdict::degraded:
      return "degraded";
    case Verdict::fail:
      return "fail";
    case Verdict::error:
      return "error";
  }
  return "error";
}

/// Where values lie in the bar, 0 to 1.
struct Scale {
  double zero = 0, one = 1;  ///< the values at its ends
  double at(double value) const { return std::clamp((value - zero) / (one - zero), 0.0, 1.0); }
};

Scale scale_of(const ExpectationResult& result) {
  if (result.min && result.max && *result.min < *result.max) {
    const double reach = (*result.max - *result.min) * 0.75;
    return {*result.min - reach, *result.max + reach};
  }
  const double limit = result.max.value_or(result.min.value_or(0));
  const double reach = limit != 0 ? std::abs(limit) : 1;
  return {limit - kLimitAt * reach / 0.55, limit + (1 - kLimitAt) * reach / 0.55};
}

std::string said(const ExpectationResult& result) {
  if (!result.value) return "no sample was judged";
  return fmt::format("value {}, limit {}, margin {}", value_text(result), limit_text(result), margin_text(result));
}

/// The text below a row: why this is expected, and where it does not hold.
Html more_of(const ExpectationResult& result) {
  const auto line = [](const Html& text) { return element("span", {{"class", "more"}}, text); };
  Html more;
  if (!result.detail.empty()) more += line(result.detail);
  if (!result.where.empty() && result.verdict != Verdict::pass) more += line(result.where);
  if (!result.because.empty()) more += line("because " + result.because);
  return more;
}

/// Buttons that show a place in the figures (report.js).
Html places_of(const ExpectationResult& result) {
  const auto button = [&](const FailurePlace& place, const char* word) {
    return element("button",
                   {{"type", "button"},
                    {"class", "jump"},
                    {"data-at", fmt::format("{:.9f}", seconds(place.at))},
                    {"data-signal", result.signal}},
                   fmt::format("{} at {:.3f} s", word, seconds(place.at)));
  };
  if (!result.first || !result.worst || result.verdict == Verdict::pass) return {};
  const bool one = result.first->at == result.worst->at;
  return element("span", {{"class", "places"}},
                 one ? button(*result.worst, "failure") : button(*result.first, "first") + button(*result.worst, "worst"));
}

std::string_view file_name(std::string_view path) { return path.substr(path.find_last_of('/') + 1); }

}  // namespace

std::string line_id(const std::string& file, std::int64_t line) {
  return fmt::format("line-{:08x}-{}", name_digest(file) & 0xFFFFFFFF, line);
}

Html margin_bar(const ExpectationResult& result) {
  const Scale scale = scale_of(result);
  const auto x = [&](double value) { return 2 + (kWidth - 4) * scale.at(value); };
  const double from = result.min ? x(*result.min) : 0, to = result.max ? x(*result.max) : kWidth;
  std::string svg = fmt::format("<svg class=\"margin\" viewBox=\"0 0 {} {}\" role=\"img\">", kWidth, kHeight);
  svg += element("title", said(result)).str();
  svg += fmt::format("<path class=\"track\" d=\"M0 {0}H{1}\"/>", kHeight / 2, kWidth);
  svg += fmt::format("<rect class=\"holds\" x=\"{:.1f}\" y=\"3\" width=\"{:.1f}\" height=\"8\"/>", from,
                     std::max(1.0, to - from));
  for (const std::optional<double>& limit : {result.min, result.max}) {
    if (limit) svg += fmt::format("<path class=\"limit\" d=\"M{:.1f} 0V{}\"/>", x(*limit), kHeight);
  }
  if (result.value && !std::isnan(*result.value)) {
    const bool holds = (!result.min || *result.value >= *result.min) && (!result.max || *result.value <= *result.max);
    const double at = std::clamp(x(*result.value), 5.0, kWidth - 5);
    svg += holds ? fmt::format("<circle class=\"good\" cx=\"{:.1f}\" cy=\"7\" r=\"4\"/>", at)
                 : fmt::format("<path class=\"bad\" d=\"M{0:.1f} 2.5l9 9m0-9l-9 9\"/>", at - 4.5);
  }
  return Html::markup(svg + "</svg>");
}

Html expectations_table(std::span<const ExpectationResult> results, const std::string& file) {
  if (results.empty()) return {};
  std::vector<std::vector<Html>> rows;
  for (const ExpectationResult& result : results) {
    const Html signal = element("code", result.signal);
    const Html where = element(
        "a", {{"href", '#' + line_id(result.file, result.line)}, {"title", result.file}},
        result.file == file ? fmt::format("{}", result.line) : fmt::format("{}:{}", file_name(result.file), result.line));
    Html verdict = verdict_badge(word_of(result.verdict));
    if (result.expect_fail) verdict += element("span", {{"class", "more"}}, "a failure is expected");
    rows.push_back({verdict, signal + Html(" ") + result.metric + more_of(result) + places_of(result), value_text(result),
                    limit_text(result), margin_bar(result), where});
  }
  return table("Every expectation of the scenario. In the bars the limit is the upright line and what is allowed is shaded.",
               {{"verdict"}, {"signal and metric"}, {"value", true}, {"limit", true}, {"margin"}, {"line"}}, rows);
}

}  // namespace evenstep::internal
