#pragma once
/// One HTML file that says what a run, a sweep, a study or anything else has found. It holds everything that it shows,
/// fetches nothing (a content security policy allows only its own scripts and styles, by their hashes), and opens from disk.
/// Only the page of a live run (scope_page.h) asks the server that it came from for what its charts show. A page has a
/// light, a dark, a narrow and a printed form, and without scripts its text, tables and pictures are still there.

#include <string>
#include <vector>

#include "evenstep/pages/html.h"

namespace evenstep {

struct PageSection {
  std::string id;     ///< for links: letters, digits and "-"
  std::string title;  ///< short, because the table of contents has it, too
  Html body;          ///< a section with an empty body is left out
};

struct Page {
  std::string title;    ///< what it is about: the name of a scenario
  std::string kind;     ///< "run", "sweep", "comparison"; in small letters above the title
  std::string verdict;  ///< "pass", "fail", "error", "degraded" or "none" (which choose its look), any other word, or empty
  Html summary;         ///< a paragraph or two below the title
  std::string command;  ///< the command that makes it again, with a button to copy it; empty: none
  std::vector<PageSection> sections;
  /// JSON for the charts of reports/pages/web/report.js; empty: the page has neither charts nor the library that draws them.
  std::string charts;
  /// The charts are those of reports/pages/web/scope.js instead, and show what the page's server sends during the run.
  bool live = false;
};

/// A verdict with its sign: "✓ pass".
Html verdict_badge(std::string_view verdict);

/// The text of the file.
std::string html_of(const Page& page);
/// Its content security policy, which is also written in the page.
std::string policy_of(const Page& page);

}  // namespace evenstep
