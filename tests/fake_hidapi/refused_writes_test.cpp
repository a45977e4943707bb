// The driver on the real transport, whose writes end in every way that the system may end them.
#include <cerrno>
#include <cmath>

#include "../device/pid/pid_bench.h"
#include "catch.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/device/hid/simulated_board.h"
#include "fake_hidapi.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const WallClock& wall_clock() {
  static const WallClock clock(WallEpoch::in(Duration{0}));
  return clock;
}

/// The time of the device is virtual, so nothing ends or is refreshed by waiting. The test makes the driver's ticks.
struct Bench {
  explicit Bench(const PidOptions& options) : driver(transport, layout_of(device), options) { driver.start(); }
  void tick(std::int64_t k, double force_N) {
    driver.read(RealTime{k * kMs});
    driver.write({force_N, 0, 0});
    transport.wait_until_sent();
  }

  VirtualClock clock;
  SimulatedPidDevice device{clock, ProgrammedMotion{Still{}, RealTime{}}, pid_device(PidFlavour::mask)};
  FakeHidapi below{device};
  HidapiTransport transport{"/dev/hidraw0", wall_clock()};
  PidDriver driver;
};

PidOptions along_x(bool ends) {
  PidOptions options = pid_options();
  options.travel_m.y = 0;
  if (!ends) options.effect_duration.reset();
  return options;
}

struct End {
  const char* name;
  int error, difference;
};
constexpr std::array<End, 6> kEnds{{{"EAGAIN", EAGAIN, 0},
                                    {"EPIPE", EPIPE, 0},
                                    {"ETIMEDOUT", ETIMEDOUT, 0},
                                    {"EINTR", EINTR, 0},
                                    {"short", 0, -1},
                                    {"long", 0, 1}}};

}  // namespace

TEST_CASE("a force whose write the system refuses is on the motors as soon as it takes one, each end, rise and release") {
  for (const End& end : kEnds) {
    for (const bool release : {false, true}) {
      for (const bool ends : {true, false}) {
        for (const int count : {1, 2, 5}) {
          Bench bench(along_x(ends));
          for (std::int64_t k = 0; k < 100; ++k) bench.tick(k, release ? 2 : 0);
          bench.below.fail({count, end.error, end.difference});
          const double wanted_N = release ? 0 : 2;
          std::int64_t ticks = 0;
          while (ticks < 50) {
            bench.tick(100 + ticks, wanted_N);
            if (std::abs(bench.device.force_N().x - wanted_N) < 1e-3) break;
            ++ticks;
          }
          INFO(end.name << " release " << release << " count " << count);
          // An interrupted write is repeated at once. Other failures cost a tick each; after that come the force and Start.
          CHECK(ticks == (end.error == EINTR ? 0 : count == 1 ? 1 : count == 2 ? 2 : 3));
          CHECK(bench.below.failed() == count);
          CHECK(bench.driver.counters().write_failures == (end.error == EINTR ? 0 : count));
        }
      }
    }
  }
}

TEST_CASE("a device that takes no write any more is given up, and its stop is tried") {
  for (const End& end : kEnds) {
    if (end.error == EINTR) continue;  // such a write is repeated as long as it is interrupted
    Bench bench(along_x(true));
    for (std::int64_t k = 0; k < 100; ++k) bench.tick(k, 2);
    bench.below.fail({1'000'000, end.error, end.difference});
    std::int64_t k = 100;
    CHECK_THROWS_WITH(
        [&] {
          for (; k < 2000; ++k) bench.tick(k, 0);
        }(),
        Catch::Contains("refused reports for 500 ms"));
    CHECK(k <= 100 + 502);
    bench.below.fail({});
    bench.driver.stop();
    CHECK((bench.device.playing() == 0 && !bench.device.actuators_enabled()));
  }
}

TEST_CASE("each request of start and stop is repeated when the system refuses it twice") {
  for (const End& end : kEnds) {
    VirtualClock clock;
    SimulatedPidDevice device(clock, ProgrammedMotion{Still{}, RealTime{}}, pid_device(PidFlavour::array));
    FakeHidapi below(device);
    HidapiTransport transport("/dev/hidraw0", wall_clock());
    PidDriver driver(transport, layout_of(device), pid_options());
    below.fail({2, end.error, end.difference});
    driver.start();
    CHECK(device.playing() == 2);
    below.fail({2, end.error, end.difference});
    driver.stop();
    CHECK((device.playing() == 0 && device.allocated() == 0 && !device.actuators_enabled()));
  }
}
