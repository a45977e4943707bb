#include <fstream>
#include <iostream>
#include <iterator>
#include <set>

#include "catch.h"
#include "evenstep/reports/measures.h"

using namespace evenstep;

namespace {

/// The metrics for which `better` is true, in alphabetical order, wrapped.
std::string list_of(Better better) {
  std::set<std::string> names;
  for (const char* form :
       {"*.interaction.*", "*.force.*", "*.buffers.*", "closed_loop.*.*", "solver.*", "events.*.*", "run", "case.*.*"}) {
    const std::vector<std::string> metrics = metrics_of_signal(form).value();
    for (const std::string& name : metrics) {
      if (better_of(form, name) == better && !is_timed(form, name)) names.insert(name);
    }
  }
  std::string text, line;
  for (const std::string& name : names) {
    const std::string word = "`" + name + "`" + (name == *names.rbegin() ? "." : ",");
    if (line.size() + word.size() + 1 > 125) text += line + '\n', line.clear();
    line += (line.empty() ? "" : " ") + word;
  }
  return text + line + '\n';
}

std::string between(const std::string& page, const std::string& begin) {
  const std::size_t first = page.find(begin + '\n');
  REQUIRE(first != std::string::npos);
  const std::size_t from = first + begin.size() + 1;
  return page.substr(from, page.find("<!-- end -->", from) - from);
}

}  // namespace

TEST_CASE("the page about comparisons lists which way every metric gets better") {
  std::ifstream in(std::string(EVENSTEP_SOURCE_DIR) + "/docs/begin/compare.md");
  const std::string page((std::istreambuf_iterator<char>(in)), {});
  CHECK(between(page, "<!-- less -->") == list_of(Better::less));
  CHECK(between(page, "<!-- more -->") == list_of(Better::more));
}

TEST_CASE("prints these lists for the page", "[.print-better]") {
  std::cout << list_of(Better::less) << '\n' << list_of(Better::more);
}

TEST_CASE("a metric has one way in which it gets better, or none, wherever it is measured") {
  const std::map<std::string, Better> known{
      {"velocity_jump", Better::less}, {"underruns", Better::less}, {"latency", Better::less},  {"k_max", Better::more},
      {"stable", Better::more},        {"gain", Better::neither},   {"judged", Better::neither}};
  for (const auto& [name, better] : known) {
    for (const char* form : {"*.interaction.*", "*.force.*", "*.buffers.*", "closed_loop.*.*", "solver.*"}) {
      const std::vector<std::string> metrics = metrics_of_signal(form).value();
      if (std::find(metrics.begin(), metrics.end(), name) != metrics.end()) CHECK(better_of(form, name) == better);
    }
  }
  CHECK(better_of("no.such.thing", "velocity_jump") == Better::neither);
  CHECK(is_timed("solver.paper", "solver_seconds"));
}
