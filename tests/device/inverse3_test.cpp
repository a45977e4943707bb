// The messages of a Haply Inverse Service, and the driver on a simulated service.

#include <glm/geometric.hpp>
#include <vector>

#include "catch.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/device/inverse3/inverse3_driver.h"
#include "evenstep/device/inverse3/simulated_inverse3.h"

using namespace evenstep;
using Catch::Contains;

namespace {

/// A message as a SOFA plugin has printed it, shortened.
const std::string kMessage =
    R"({"inverse3":[{"device_id":"04EA","state":{"angular_position":{"a0":-30.9,"a1":53.8,"a2":-6.6},"control_mode":"idle",)"
    R"("cursor_position":{"x":0.10428079,"y":-0.03648221,"z":-0.06100729},"cursor_velocity":{"x":0,"y":0,"z":0},)"
    R"("transform":{"position":{"x":7,"y":7,"z":7}}},"status":{"calibrated":true,"in_use":false,"power_supply":true}}],)"
    R"("verse_grip":[],"session_id":7})";

std::string error_in(const std::string& message) {
  const auto read = read_inverse3_message(message);
  return read ? "" : read.error();
}

/// kMessage with one part replaced.
std::string with(const std::string& part, const std::string& other) {
  std::string text = kMessage;
  const std::size_t at = text.find(part);
  REQUIRE(at != std::string::npos);
  return text.replace(at, part.size(), other);
}

template <class Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return {};
}

constexpr Duration kInverse3Tick{1'000'000};

struct Inverse3Bench {
  explicit Inverse3Bench(SimulatedInverse3Options with = {}, const Motion& motion = Still{}, const Inverse3Options& own = {})
      : service(clock, ProgrammedMotion{motion, RealTime{}}, std::move(with)), driver(service, own) {}
  DeviceSample tick(const glm::dvec3& force_N) {
    clock.wait_until(clock.now() + kInverse3Tick);
    const DeviceSample sample = driver.read(clock.now());
    driver.write(force_N);
    return sample;
  }
  VirtualClock clock;
  SimulatedInverse3 service;
  Inverse3Driver driver;
};

/// A link that answers what the test tells it to.
struct Scripted final : Inverse3Link {
  Read read(std::string& text) override {
    if (!answer) return Read::nothing;
    text = *answer;
    return is_gone ? Read::gone : Read::message;
  }
  void post(std::string text) override { posted = std::move(text); }
  void rest(std::string text) override { rested = std::move(text); }
  const std::string& first_message() const override { return first; }
  const std::string& name() const override { return address; }
  std::string first = kMessage, address = "ws://127.0.0.1:10001", posted, rested;
  std::optional<std::string> answer;
  bool is_gone = false;
};

}  // namespace

TEST_CASE("inverse3: a message as the service prints it is read") {
  const auto devices = read_inverse3_message(kMessage);
  REQUIRE(devices);
  REQUIRE(devices->size() == 1);
  const Inverse3State& device = devices->front();
  CHECK(device.device_id == "04EA");
  CHECK(*device.position_m == glm::dvec3(0.10428079, -0.03648221, -0.06100729));
  CHECK(*device.calibrated);
  CHECK_FALSE(*device.in_use);
}

TEST_CASE("inverse3: what a message does not say is empty, and other members are skipped wherever they are") {
  CHECK(read_inverse3_message("{}")->empty());
  CHECK(read_inverse3_message(R"({"inverse3":[]})")->empty());
  CHECK(read_inverse3_message(R"({"status":{"calibrated":1},"x":{"inverse3":[{"device_id":5}]}})")->empty());
  const auto bare = read_inverse3_message(R"({"inverse3":[{"device_id":"A","new":{"state":[{"cursor_position":1}]}}]})");
  REQUIRE(bare);
  CHECK_FALSE(bare->front().position_m);
  CHECK_FALSE(bare->front().calibrated);
}

TEST_CASE("inverse3: a message that is no JSON, or of another shape, is refused as a whole and says why") {
  for (const char* text : {"", "{", "nonsense", "[]", "5", "null", "{}{}", "\xff", R"({"inverse3":[{"device_id":"A"})"})
    CHECK_FALSE(error_in(text).empty());
  CHECK_THAT(error_in(with("0.10428079", "NaN")), Contains("no JSON at byte"));
  CHECK_THAT(error_in(with("0.10428079", "1e999")), Contains("no JSON at byte"));
  CHECK(error_in(with("0.10428079", "null")) == "'x' is of another type");
  CHECK(error_in(with("0.10428079", "\"0\"")) == "'x' is of another type");
  CHECK(error_in(with(R"("x":0.10428079,)", "")) == "'cursor_position' has no 'x'");
  CHECK(error_in(with("0.10428079", "2.001")) == "'cursor_position' is more than 2 m away");
  CHECK(error_in(with("0.10428079", "-1e300")) == "'cursor_position' is more than 2 m away");
  CHECK(error_in(with(R"({"x":0.10428079,"y":-0.03648221,"z":-0.06100729})", "[0, 0, 0]")) ==
        "'cursor_position' is of another type");
  CHECK(error_in(with(R"("calibrated":true)", R"("calibrated":1)")) == "'calibrated' is of another type");
  CHECK(error_in(with(R"("device_id":"04EA",)", "")) == "a device has no device_id");
  CHECK(error_in(R"({"inverse3":{"049D":{}}})") == "'inverse3' is of another type");
  CHECK(error_in(R"({"inverse3":["049D"]})") == "a value where an object was expected");
}

TEST_CASE("inverse3: an id that a terminal or JSON would read otherwise is refused") {
  for (const char* id : {"", "\\u001b[2J", "a b", "\\\"", "\\\\", "\xc3\xa4", "\\u0000"})
    CHECK_FALSE(error_in(with("04EA", id)).empty());
  CHECK(error_in(with("04EA", std::string(64, 'A'))).empty());
  CHECK_FALSE(error_in(with("04EA", std::string(65, 'A'))).empty());
}

TEST_CASE("inverse3: size, depth and number of devices are limited") {
  const auto padded = [](std::size_t size) { return kMessage + std::string(size - kMessage.size(), ' '); };
  CHECK(error_in(padded(kLongestInverse3Message)).empty());
  CHECK(error_in(padded(kLongestInverse3Message + 1)) == "longer than 65536 bytes");
  const auto nested = [](int depth) {
    return R"({"x":)" + std::string(static_cast<std::size_t>(depth), '[') +
           std::string(static_cast<std::size_t>(depth), ']') + "}";
  };
  CHECK(error_in(nested(kDeepestInverse3Message - 1)).empty());
  CHECK(error_in(nested(kDeepestInverse3Message)) == "nested more than 32 deep");
  CHECK_FALSE(error_in(std::string(kLongestInverse3Message, '[')).empty());
  const auto many = [](std::size_t count) {
    std::string list;
    for (std::size_t i = 0; i < count; ++i) list += (i > 0 ? "," : "") + std::string(R"({"device_id":"A"})");
    return R"({"inverse3":[)" + list + "]}";
  };
  CHECK(error_in(many(kMostInverse3Devices)).empty());
  CHECK(error_in(many(kMostInverse3Devices + 1)) == "more than 64 devices");
}

TEST_CASE("inverse3: of 20,000 damaged messages each is read or refused, and none is read with a position out of reach") {
  std::uint64_t state = 1;
  const auto random = [&](std::size_t below) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>((state >> 33) % below);
  };
  int refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string text = kMessage;
    for (std::size_t damage = 0; damage <= random(4); ++damage) {
      const std::size_t at = random(text.size());
      switch (random(4)) {
        case 0:
          text[at] = static_cast<char>(random(256));
          break;
        case 1:
          text.erase(at, 1 + random(20));
          break;
        case 2:
          text.insert(at, text.substr(random(text.size()), random(40)));
          break;
        default:
          text.insert(at, 1, "0-9.e{}[],:\"tn"[random(14)]);
      }
      if (text.empty()) text = "{";
    }
    const auto read = read_inverse3_message(text);
    if (!read) {
      ++refused;
      CHECK_FALSE(read.error().empty());
      continue;
    }
    for (const Inverse3State& device : *read) {
      REQUIRE_FALSE(device.device_id.empty());
      if (device.position_m) REQUIRE(glm::length(*device.position_m) < 2 * kInverse3Reach_m);
    }
  }
  CHECK(refused > 10'000);
  CHECK(refused < 19'000);
}

TEST_CASE("inverse3: the address of a service is read, and one of another machine is told from one of this") {
  const auto good = [](const char* text, const char* host, unsigned port, const char* id, bool loopback) {
    INFO(text);
    const auto address = read_inverse3_address(text);
    REQUIRE(address);
    CHECK(address->host == host);
    CHECK(address->port == port);
    CHECK(address->device_id == id);
    CHECK(address->is_loopback == loopback);
  };
  good("ws://127.0.0.1:10001#049D", "127.0.0.1", 10001, "049D", true);
  good("ws://localhost", "127.0.0.1", 10001, "", true);
  good("ws://localhost:1/", "127.0.0.1", 1, "", true);
  good("ws://[::1]:65535/#A", "::1", 65535, "A", true);
  good("ws://127.9.9.9", "127.9.9.9", 10001, "", true);
  good("ws://192.168.0.2", "192.168.0.2", 10001, "", false);
  good("ws://[::2]", "::2", 10001, "", false);
  for (const char* bad :
       {"", "127.0.0.1", "http://127.0.0.1", "ws://", "ws://haply", "ws://127.0.0.1.5", "ws://127.0.0", "ws://256.0.0.1",
        "ws://127.0.0.1:", "ws://127.0.0.1:0", "ws://127.0.0.1:65536", "ws://127.0.0.1:1x", "ws://127.0.0.1/path",
        "ws://127.0.0.1#", "ws://127.0.0.1#a b", "ws://[::1", "ws://[]", "ws://[localhost]", "ws://127.0.0.1 "}) {
    INFO(bad);
    CHECK_FALSE(read_inverse3_address(bad).ok());
  }
}

TEST_CASE("inverse3: a force along each axis is rendered as it is and nothing is left after stop") {
  Inverse3Bench bench;
  bench.driver.start();
  for (const glm::dvec3 force_N : {glm::dvec3{1.5, 0, 0}, {0, -2, 0}, {0, 0, 2.5}, {1e-7, -0.25, 0.125}}) {
    bench.tick(force_N);
    CHECK(bench.service.motors().force_N == glm::dvec3(glm::vec3(force_N)));
  }
  bench.driver.stop();
  CHECK(bench.service.motors().force_N == glm::dvec3(0));
  CHECK_THAT(error_of([&] { bench.driver.write(glm::dvec3(0)); }), Contains("before start() or after stop()"));
}

TEST_CASE("inverse3: positions count from the origin, and each tick has one") {
  SimulatedInverse3Options options;
  options.origin_m = {0.01, -0.12, 0.15};
  Inverse3Options own;
  own.origin_m = options.origin_m;
  Inverse3Bench bench(options, ConstantVelocity{{0.1, 0.05, -0.02}}, own);
  bench.driver.start();
  for (int i = 1; i <= 100; ++i) {
    const DeviceSample sample = bench.tick(glm::dvec3(0));
    CHECK(sample.fresh);
    CHECK(sample.drivable);
    // The service prints numbers in single precision, which gives 0.15 m to within 15 nm.
    CHECK(glm::length(sample.position_m - glm::dvec3(0.1, 0.05, -0.02) * (i * 1e-3)) < 20e-9);
  }
  CHECK(bench.driver.counters().reports == 100);
  CHECK(bench.driver.counters().stale == 0);
}

TEST_CASE("inverse3: a program that hangs pushes no longer than the link holds its force") {
  SimulatedInverse3Options options;
  options.hold = {50'000'000};
  Inverse3Bench bench(options);
  bench.driver.start();
  bench.tick({2, 0, 0});
  const RealTime written = bench.clock.now();
  bench.clock.wait_until(written + Duration{49'000'000});
  CHECK(bench.service.motors().force_N.x == 2);
  bench.clock.wait_until(written + Duration{51'000'000});
  CHECK(bench.service.motors().force_N.x == 0);
}

TEST_CASE("inverse3: a device that another program uses is refused, unless it may be shared") {
  SimulatedInverse3Options options;
  options.in_use = true;
  CHECK_THAT(error_of([&] { Inverse3Bench bench(options); }), Contains("another program uses device 049D"));
  Inverse3Options own;
  own.shared = true;
  CHECK(error_of([&] { Inverse3Bench bench(options, Still{}, own); }).empty());
}

TEST_CASE("inverse3: of several devices one must be named, and it must be there") {
  Scripted link;
  const auto error = [&](const std::string& id) {
    Inverse3Options options;
    options.device_id = id;
    return error_of([&] { Inverse3Driver driver(link, options); });
  };
  CHECK(error("").empty());
  CHECK(error("04EA").empty());
  CHECK_THAT(error("049D"), Contains("no device 049D, but 04EA"));
  link.first = R"({"inverse3":[{"device_id":"A"},{"device_id":"B"}]})";
  CHECK_THAT(error(""), Contains("more than one device (A, B)"));
  CHECK(error("B").empty());
  CHECK_THAT(link.rested, Contains(R"("device_id":"B")"));
  link.first = R"({"inverse3":[]})";
  CHECK_THAT(error(""), Contains("no Inverse3 is connected"));
  link.first = R"({"version":4,"devices":{"inverse3":[]}})";
  CHECK_THAT(error(""), Contains("no Inverse3 is connected"));
  link.first = R"({"inverse3":{"A":{}}})";
  CHECK_THAT(error(""), Contains("not what an Inverse Service says: 'inverse3' is of another type"));
}

TEST_CASE("inverse3: a device that is not calibrated has no position and may not be driven") {
  SimulatedInverse3Options options;
  options.uncalibrated_at = RealTime{5'000'000};
  Inverse3Bench bench(options, Still{{0.01, 0, 0}});
  bench.driver.start();
  for (int i = 1; i <= 8; ++i) {
    const DeviceSample sample = bench.tick(glm::dvec3(0));
    CHECK(sample.drivable == (i < 5));
    CHECK(sample.fresh == (i < 5));
    CHECK(sample.position_m.x == Approx(0.01));
  }
  CHECK(bench.driver.own_counters().at("inverse3_uncalibrated") == 4);
}

TEST_CASE("inverse3: a message that cannot be used is counted and leaves the last position") {
  Scripted link;
  Inverse3Driver driver(link, {});
  const auto read = [&](int ms, const std::string& answer) {
    link.answer = answer;
    return driver.read(RealTime{ms * 1'000'000});
  };
  CHECK(read(1, kMessage).fresh);
  CHECK_FALSE(read(2, "{").fresh);
  CHECK_FALSE(read(3, with("04EA", "FFFF")).fresh);
  CHECK_FALSE(read(4, R"({"inverse3":[]})").fresh);
  const DeviceSample last = read(5, R"({"inverse3":[{"device_id":"04EA"}]})");
  CHECK_FALSE(last.fresh);
  CHECK(last.position_m.x == 0.10428079);
  CHECK(driver.counters().malformed == 1);
  CHECK(driver.counters().stale == 4);
  CHECK(driver.own_counters().at("inverse3_absent") == 3);
}

TEST_CASE("inverse3: a service that tells no position for ten seconds, or is gone, ends the run and says what to do") {
  Scripted link;
  Inverse3Driver driver(link, {});
  driver.read(RealTime{1'000'000'000});
  driver.read(RealTime{11'000'000'000});
  CHECK_THAT(error_of([&] { driver.read(RealTime{11'000'000'001}); }), Contains("no position of device 04EA for 10 s"));
  link.is_gone = true;
  link.answer = "the connection was closed";
  CHECK(error_of([&] { driver.read(RealTime{1}); }) ==
        "ws://127.0.0.1:10001: the connection was closed; start the service and run again");
}
