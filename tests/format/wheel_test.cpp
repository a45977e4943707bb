// A wheel is told in degrees and newton meters, and judged in meters and newtons at its rim.
#include <string>
#include <utility>
#include <vector>

#include "catch.h"
#include "checked.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

/// A device with this `driver`, and these keys in its table.
std::string device(const std::string& driver, const std::string& keys) {
  return "name = \"left\"\ndriver = \"" + driver + "\"\n" + driver + " = { " + keys + " }";
}

}  // namespace

TEST_CASE("The turn of a wheel is a travel along its rim and its torque a force there, for both drivers of effects") {
  const std::string wheel = "wheel = { turn = \"2.5 turns\", radius = \"14 cm\", torque = \"7000 mN m\" }";
  const auto of = [&](const std::string& driver, const std::string& keys) {
    return good(changed(kSpring, "name = \"left\"", device(driver, keys))).devices[0].driver;
  };
  const PidOptions rim = std::get<PidSpec>(of("pid", wheel)).options;
  // 900 degrees of a circle with a radius of 0.14 m, where 7 N m are 50 N.
  CHECK(rim.travel_m.x == Approx(0.14 * 5 * 3.14159265358979).epsilon(1e-14));
  CHECK((rim.travel_m.y == 0 && rim.travel_m.z == 0));
  CHECK(*rim.full_scale_N == Approx(50).epsilon(1e-14));
  const EvdevOptions same = std::get<EvdevSpec>(of("evdev", wheel)).options;
  CHECK(same.travel_m == rim.travel_m);
  CHECK(same.full_scale_N == rim.full_scale_N);
  const PidOptions only_read = std::get<PidSpec>(of("pid", "wheel = { turn = \"900 deg\", radius = \"14 cm\" }")).options;
  CHECK(only_read.travel_m == rim.travel_m);
  CHECK_FALSE(only_read.full_scale_N);
}

TEST_CASE("What is wrong with a wheel is named where it stands, with what to write") {
  const std::string turn = "turn = \"900 deg\"", radius = "radius = \"14 cm\"";
  for (const auto& [keys, error] : std::vector<std::pair<std::string, std::string>>{
           {"wheel = { " + turn + ", " + radius + ", torque = \"5 N\" }",
            "scenario.toml:18:64: error: 'torque': 'N' is a unit of force, not of torque"},
           {"wheel = { " + turn + ", " + radius + ", torque = \"5 Nm\" }", "not a unit of torque; did you mean 'N m'?"},
           {"wheel = { turn = \"16 rad\", " + radius + " }", "'rad' is not a unit of angle; known: deg, turn"},
           {"wheel = { turn = \"900 °\", " + radius + " }", "did you mean 'deg'?"},
           {"wheel = { turn = \"0 deg\", " + radius + " }", "'turn': \"0 deg\" is out of range"},
           {"wheel = { " + turn + " }", "has no 'radius'"},
           {"full_scale = \"5 N\", wheel = { " + turn + ", " + radius + " }",
            "'full_scale' follows from 'wheel'; remove one of them"},
           {"travel = [\"1 m\", \"0 m\", \"0 m\"], wheel = { " + turn + ", " + radius + " }",
            "'travel' follows from 'wheel'; remove one of them"},
           {"gain = 1.0",
            "'travel': no axis is used; write the travel of one, [\"200 mm\", \"0 mm\", \"0 mm\"], or the turn"}}) {
    INFO(keys);
    const ReadResult result = read_text(changed(kSpring, "name = \"left\"", device("pid", keys)));
    CHECK_FALSE(result);
    CHECK_THAT(errors_of(result), Contains(error));
  }
}
