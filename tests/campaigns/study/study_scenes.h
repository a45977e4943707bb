#pragma once
// Scenes small enough for many cells.

#include <string>
#include <vector>

#include "catch.h"
#include "evenstep/campaigns/study.h"
#include "evenstep/format/scenario.h"

namespace evenstep::test {

/// The shipped study with a block of 5 x 5 x 5 whose top middle is dragged. There is one repeat per cell, 16 ms long.
inline Scenario small_study(const std::vector<std::string>& set = {}) {
  std::vector<std::string> all{"scene.lattice=[5, 5, 5]", "device.left.grab.center=[\"10 mm\", \"10 mm\", \"20 mm\"]",
                               "device.left.grab.radius=\"5.5 mm\"", "study.duration=\"16 ms\"", "study.repeats=1"};
  all.insert(all.end(), set.begin(), set.end());
  const ReadResult result =
      read_scenario(std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/stiff/study-block.toml", {all, std::nullopt});
  for (const Diagnostic& error : result.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(result);
  return *result;
}

/// A chain along x between a wall and a tool that holds the last particle still. It swings in its mode `p`. The springs stay
/// on one line, where they are linear, so the solution is a cosine.
struct ChainMode {
  static constexpr int kMobile = 14;
  int p = 1;
  double amplitude_m = 1e-4;

  Scenario scenario(const std::vector<std::string>& set = {}) const;
  /// The amplitude of the mobile particle j = 1 .. kMobile.
  double shape(int j) const;
  double omega_per_s() const;  ///< 2 sqrt(k / m) sin(p pi / (2 (n + 1))): docs/choose/numerics.md
};

}  // namespace evenstep::test
