// Writes a sample of every file of a run folder, for the parsers of others.
#include <array>
#include <cstdio>
#include <fstream>
#include <string>

#include "evenstep/reports/figures.h"
#include "evenstep/reports/trace_json.h"
#include "evenstep/reports/writers.h"
#include "samples.h"

using namespace evenstep;

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: reports_samples DIR\n"), 2;
  const std::string folder = argv[1];
  bool written = true;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream out(folder + '/' + name, std::ios::binary);
    out << text;
    out.close();
    written = written && out;
  };
  const RunRecord run = synthetic::nasty_run();
  const auto results = synthetic::nasty_results();
  write("summary.json", summary_json(run, measure(run), results, "0.1.0", "error"));
  std::array suites{synthetic::nasty_suite(), synthetic::nasty_suite()};
  suites[0].whole = JunitSuite::Whole::broken;
  suites[0].why = synthetic::kNastyText;
  suites[0].reproduce = "evenstep run 'a&b.toml' --seed 1";
  write("nasty.txt", synthetic::kNastyText);
  write("junit.xml", junit_xml(suites));
  write("series.csv", synthetic::written(series_csv, run));
  write("underruns.csv", synthetic::written(underruns_csv, run));
  RunRecord named = run;
  named.strategies[1].name = named.strategies[1].devices[0].name = synthetic::kNastyText;
  write("hostile.csv", synthetic::written(series_csv, named));
  write("trace.json", synthetic::written(trace_json, named));
  write("error-over-time.svg", error_over_time_svg(synthetic::reference_run({12'000'000'000}), {}).value());
  write("figure-1a.svg", figure_1a_svg(run, "left"));
  write("figure-1b.svg", figure_1b_svg(run, "left"));
  write("figure-2to4.svg", figure_2to4_svg(run, "paper", "left"));
  write("figure-2to4-direct.svg", figure_2to4_svg(run, "direct", "left"));
  write("figure-empty.svg", figure_1a_svg(RunRecord{}, synthetic::kNastyText));
  return written ? 0 : 1;
}
