#pragma once
// Files of a test, and a small sweep.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "catch.h"
#include "temporary_folder.h"

namespace evenstep::test {

using testing::TemporaryFolder;

inline std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file.good());
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// A third of a second of the shipped spring with 10 % jitter. Forces are late if the latency is short.
inline std::string small_scenario(const std::string& sweep) {
  return std::string("format = 1\nextends = [\"") + EVENSTEP_SOURCE_DIR +
         "/scenarios/paper/figure-1-spring.toml\"]\nname = \"small\"\n"
         "expect = [{ signal = \"left.force.phase_locked\", metric = \"underruns\", equals = 0 }]\n"
         "[run]\nduration = \"0.3 s\"\nwarmup = \"0.1 s\"\nstrategies = [\"phase_locked\"]\n"
         "[timing]\njitter = { visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }\n"
         "[remap]\nlead = \"6 ms\"\n" +
         sweep;
}

}  // namespace evenstep::test
