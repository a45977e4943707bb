#include "evenstep/pages/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "src/page_files.h"

namespace evenstep {
namespace {

using internal::PageFile;

/// Verdicts are told apart by a sign and a word, and only then by colour.
struct VerdictLook {
  std::string_view name, sign;
};
constexpr std::array kVerdicts = std::to_array<VerdictLook>(
    {{"pass", "✓"}, {"fail", "✗"}, {"error", "!"}, {"degraded", "~"}, {"none", "?"}, {"skipped", "–"}});

Html script(const PageFile& file) { return element("script", Html::markup(std::string(file.text))); }
Html style(const PageFile& file) { return element("style", Html::markup(std::string(file.text))); }

const PageFile& script_of(const Page& page) { return page.live ? internal::scope_js : internal::report_js; }

Html head_of(const Page& page) {
  const bool charts = !page.charts.empty();
  Html head = Html::markup("<meta charset=\"utf-8\">\n");
  head += Html::markup(fmt::format("<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n", policy_of(page)));
  head += Html::markup("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
  head += Html::markup("<meta name=\"color-scheme\" content=\"light dark\">\n");
  head += element("title", page.verdict.empty() ? page.title : fmt::format("{}: {}", page.verdict, page.title));
  head += Html::markup("\n") + style(internal::report_css);
  if (charts)
    head += style(internal::uPlot_min_css) + Html::markup(fmt::format("\n<!-- uPlot:\n{}-->", internal::LICENSE.text));
  return head;
}

Html banner_of(const Page& page) {
  Html banner = element("p", {{"class", "kind"}}, page.kind);
  banner += element("h1", page.title);
  const Html verdict = page.verdict.empty() ? Html() : verdict_badge(page.verdict);
  banner += element("div", {{"class", "outcome"}}, verdict + element("div", page.summary));
  if (!page.command.empty()) {
    banner += element("div", {{"class", "command"}},
                      element("code", {{"id", "command"}}, page.command) +
                          element("button", {{"type", "button"}, {"data-copy", "command"}}, "Copy"));
  }
  return element("header", banner);
}

Html contents_of(const Page& page) {
  Html links;
  for (const PageSection& section : page.sections) {
    if (!section.body.empty()) links += element("a", {{"href", '#' + section.id}}, section.title);
  }
  return links.empty() ? Html() : element("nav", {{"aria-label", "Contents"}}, links);
}

}  // namespace

Html verdict_badge(std::string_view verdict) {
  const auto known =
      std::find_if(kVerdicts.begin(), kVerdicts.end(), [&](const VerdictLook& look) { return look.name == verdict; });
  const bool found = known != kVerdicts.end();
  const std::string look = "verdict " + std::string(found ? known->name : "other");
  const Html sign = found ? element("span", {{"class", "sign"}, {"aria-hidden", "true"}}, known->sign) : Html();
  return element("span", {{"class", look}}, sign + Html(verdict));
}

/// Only our own scripts and styles; nothing is fetched, sent, embedded or submitted, except for what a live page fetches.
std::string policy_of(const Page& page) {
  const bool charts = !page.charts.empty();
  const auto hash = [](const PageFile& file) { return fmt::format(" 'sha256-{}'", file.sha256); };
  return fmt::format("default-src 'none'; script-src{}{}; style-src{}{}; {}base-uri 'none'; form-action 'none'",
                     hash(internal::page_js), charts ? hash(internal::uPlot_iife_min_js) + hash(script_of(page)) : "",
                     hash(internal::report_css), charts ? hash(internal::uPlot_min_css) : "",
                     page.live ? "connect-src 'self'; " : "");
}

std::string html_of(const Page& page) {
  Html main;
  for (const PageSection& section : page.sections) {
    if (section.body.empty()) continue;
    main += element("section", {{"id", section.id}}, element("h2", section.title) + section.body) + Html::markup("\n");
  }
  Html body = element("a", {{"class", "skip"}, {"href", "#content"}}, "Skip to the content");
  body += banner_of(page) + contents_of(page) + element("main", {{"id", "content"}}, main);
  if (!page.charts.empty()) {
    std::string data;  // "<" only occurs within JSON's strings: this way no "</script>" can end the element
    for (const char c : page.charts) data += c == '<' ? "\\u003c" : std::string(1, c);
    body += element("script", {{"type", "application/json"}, {"id", "charts"}}, Html::markup(std::move(data)));
    body += Html::markup("\n") + script(internal::uPlot_iife_min_js) + Html::markup("\n");
    body += script(script_of(page));
  }
  body += Html::markup("\n") + script(internal::page_js);
  return fmt::format("<!doctype html>\n<html lang=\"en\">\n<head>\n{}\n</head>\n<body>\n{}\n</body>\n</html>\n",
                     head_of(page).str(), body.str());
}

}  // namespace evenstep
