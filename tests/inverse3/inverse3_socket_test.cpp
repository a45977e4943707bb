// The connection to a Haply Inverse Service, and the driver that uses it, over this machine's loopback.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <functional>
#include <thread>

#include "catch.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/force_guard.h"
#include "evenstep/device/inverse3/inverse3_driver.h"
#include "evenstep/device/inverse3/inverse3_socket.h"
#include "service.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

constexpr Duration kSecond{1'000'000'000}, kPatience{10'000'000'000};

void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

struct Client {
  explicit Client(const std::string& address, Inverse3SocketOptions options = {})
      : socket(*read_inverse3_address(address), clock, options), driver(socket, {}) {
    driver.start();
  }
  /// Makes ticks until `done`, for at most five seconds. Nothing is asserted about how fast the machine is.
  bool until(const std::function<bool(const DeviceSample&)>& done, const glm::dvec3& force_N = glm::dvec3(0)) {
    for (int i = 0; i < 5000; ++i) {
      const DeviceSample sample = driver.read(clock.now());
      if (done(sample)) return true;
      driver.write(force_N);
      sleep_ms(1);
    }
    return false;
  }
  WallClock clock{WallEpoch::in(Duration{})};
  Inverse3Socket socket;
  Inverse3Driver driver;
};

template <class Call>
std::string error_of(Call call) {
  try {
    call();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return {};
}

std::string refusal(const std::string& address, Duration patience = kSecond) {
  return error_of([&] { Client client(address, {.patience = patience}); });
}

ServiceOptions saying(std::function<std::optional<std::string>(int)> instead) {
  ServiceOptions options;
  options.instead = std::move(instead);
  return options;
}

}  // namespace

TEST_CASE("inverse3 socket: a hand behind the service feels the force, and its position comes back") {
  Service service;
  Client client(service.address());
  // At 200 N/m, 2 N move the hand by 10 mm.
  CHECK(client.until([](const DeviceSample& sample) { return sample.position_m.x > 8e-3; }, {2, 0, 0}));
  CHECK(service.force_N() == glm::dvec3(2, 0, 0));
  CHECK(service.inventories_asked() >= 1);  // the driver asks until it has said what to send
  CHECK(client.driver.counters().malformed == 0);
  client.driver.stop();
  for (int i = 0; i < 5000 && service.force_N().x != 0; ++i) sleep_ms(1);
  CHECK(service.force_N() == glm::dvec3(0));
}

TEST_CASE("inverse3 socket: without forces the service is asked all the same, with a zero force") {
  Service service;
  Client client(service.address());
  int fresh = 0;
  for (int i = 0; i < 2000 && fresh < 20; ++i) {
    fresh += client.driver.read(client.clock.now()).fresh;
    sleep_ms(1);
  }
  CHECK(fresh == 20);
  for (const double force : service.forces_x_N()) CHECK(force == 0);
}

TEST_CASE("inverse3 socket: a program that hangs pushes no longer than `hold`, and zero is the last that is sent") {
  Service service;
  {
    Client client(service.address(), {.hold = Duration{50'000'000}});
    CHECK(client.until([&](const DeviceSample&) { return service.force_N().x == 1; }, {1, 0, 0}));
    for (int i = 0; i < 5000 && service.force_N().x != 0; ++i) sleep_ms(1);
    CHECK(service.force_N().x == 0);
    CHECK(client.until([&](const DeviceSample&) { return service.force_N().x == 3; }, {3, 0, 0}));
  }
  REQUIRE_FALSE(service.forces_x_N().empty());
  CHECK(service.forces_x_N().back() == 0);
}

TEST_CASE("inverse3 socket: where nobody listens, or not a WebSocket, or nothing is said, that is said in time") {
  std::string nobody;
  {
    const Service gone;
    nobody = gone.address();
  }
  const RealTime began = WallClock(WallEpoch{}).now();
  CHECK_THAT(refusal(nobody), Contains("no connection: is the Inverse Service running?") && Contains("refused"));
  CHECK(inverse3_devices(*read_inverse3_address(nobody)).empty());
  CHECK(WallClock(WallEpoch{}).now() - began < kSecond);  // it does not wait

  ServiceOptions dumb, late;
  dumb.speaks = false;
  late.first = false;
  const Service silent(dumb), mute(late);
  CHECK_THAT(refusal(silent.address(), Duration{100'000'000}), Contains("does not answer as a WebSocket (waited 0.1 s)"));
  CHECK_THAT(refusal(mute.address(), Duration{100'000'000}), Contains("it says nothing (waited 0.1 s)"));
  CHECK(inverse3_devices(*read_inverse3_address(silent.address())).empty());
}

TEST_CASE("inverse3 socket: an address of another machine is refused before anything is sent, unless it is allowed") {
  CHECK_THAT(refusal("ws://192.0.2.1", Duration{50'000'000}), Contains("not of this machine"));
}

TEST_CASE("inverse3 socket: a second client is told that the service refuses it, or that the device is in use") {
  ServiceOptions one;
  one.refuses_from = 1;
  const Service alone(one);
  Client first(alone.address());
  CHECK_THAT(refusal(alone.address()), Contains("does not answer as a WebSocket"));

  ServiceOptions held;
  held.in_use = true;
  const Service busy(held);
  CHECK_THAT(refusal(busy.address()), Contains("another program uses device 049D"));
  const auto listed = inverse3_devices(*read_inverse3_address(busy.address()));
  REQUIRE(listed.size() == 1);
  CHECK(listed[0].device_id == "049D");
  CHECK(*listed[0].in_use);
  CHECK(busy.forces_x_N().empty());
}

TEST_CASE("inverse3 socket: a service that closes the connection ends the run with the reason") {
  ServiceOptions options;
  options.closes_after = 20;
  const Service service(options);
  Client client(service.address());
  CHECK_THAT(error_of([&] { client.until([](const DeviceSample&) { return false; }); }),
             Contains("the connection was closed") && Contains("start the service and run again"));
}

TEST_CASE(
    "inverse3 socket: a service that closes the connection and is there again is driven anew, and its force rises from "
    "zero") {
  std::atomic<bool> back{false};
  ServiceOptions options;
  options.closes_after = 200;
  options.closes = 1;
  options.refuses = [&back](int connection) { return connection > 0 && !back; };
  const Service service(options);
  Client client(service.address(), {.hold = kSecond, .returns = kPatience});
  ForceLimits limits;
  limits.cut.ramp_up = Duration{200'000'000};
  limits.cut.ramp_down = Duration{10'000'000};
  limits.cut.stale_force = kSecond * 1000;
  ForceGuard guard(limits);
  std::vector<std::pair<RealTime, double>> passed;
  const auto guarded = [&](const std::function<bool(const DeviceSample&)>& done) {
    for (int i = 0; i < 20'000; ++i) {
      const RealTime now = client.clock.now();
      const DeviceSample sample = client.driver.read(now);
      const glm::dvec3 force_N = guard.pass(now, {2, 0, 0}, {sample, now});
      passed.emplace_back(now, force_N.x);
      client.driver.write(force_N);
      if (done(sample)) return true;
      sleep_ms(1);
    }
    return false;
  };
  const auto lost = [&](const DeviceSample& sample) { return client.socket.times().lost == 1 && !sample.drivable; };
  REQUIRE(guarded([&](const DeviceSample& sample) { return lost(sample) && passed.back().second == 0; }));
  const std::vector<double> before = service.forces_x_N();
  CHECK(before.back() > 0);
  client.socket.post(inverse3_force_message("049D", {3, 0, 0}));  // posted without a connection, so never sent
  passed.erase(passed.begin(), passed.end() - 1);
  back = true;
  REQUIRE(guarded(
      [&](const DeviceSample&) { return service.forces_x_N().size() >= before.size() + 10 && service.force_N().x == 2; }));
  std::vector<double> after = service.forces_x_N();
  after.erase(after.begin(), after.begin() + static_cast<std::ptrdiff_t>(before.size()));
  // The ramp begins with the last tick without a force. How late later ticks are depends on the machine.
  RealTime zero;
  for (const auto& [at, force_N] : passed) {
    if (force_N == 0) zero = at;
    CHECK(force_N <= Approx(2 * seconds(at - zero) / seconds(limits.cut.ramp_up)));
  }
  // The newest force is sent, so a late sender skips older ones. What arrives is a part of what the guard let through, in
  // the same order.
  CHECK(std::is_sorted(after.begin(), after.end()));
  for (const double sent : after)
    CHECK(std::any_of(passed.begin(), passed.end(), [&](const auto& tick) { return tick.second == sent; }));
  CHECK(after.back() == 2);
  CHECK(client.socket.times().lost == 1);
  CHECK(guard.counters().cuts_device == 1);
}

TEST_CASE("inverse3 socket: a service that does not come back in time ends the run, and says for how long it was tried") {
  ServiceOptions options;
  options.closes_after = 20;
  options.refuses_from = 1;
  const Service service(options);
  Client client(service.address(), {.returns = kSecond});
  CHECK_THAT(error_of([&] { client.until([](const DeviceSample&) { return false; }); }),
             Contains("the connection was closed, and not there again within 1 s: ") &&
                 Contains("does not answer as a WebSocket") && Contains("start the service and run again"));
}

TEST_CASE("inverse3 socket: what comes back as another device is refused and gets no force, and so is one that is in use") {
  ServiceOptions options;
  options.closes_after = 20;
  options.closes = 1;
  options.returns_as = "FFFF";
  const Service service(options);
  Client client(service.address(), {.returns = kSecond});
  std::vector<bool> drivable;
  CHECK_THAT(
      error_of([&] {
        client.until([&](const DeviceSample& sample) { return drivable.push_back(sample.drivable), false; }, {1, 0, 0});
      }),
      Contains("within 1 s: the service came back without device 049D, but with FFFF"));
  REQUIRE_FALSE(drivable.empty());
  CHECK_FALSE(drivable.back());
  for (int connection = 1; connection < 10; ++connection) CHECK(service.forces_x_N(connection).empty());
  CHECK(client.socket.times().lost == 1);  // refused connections do not count as further losses

  // From the second connection on, this service says that the same device is used by somebody else.
  std::atomic<int> inventories{0};
  ServiceOptions held;
  held.closes_after = 20;
  held.closes = 1;
  held.instead = [&](int n) -> std::optional<std::string> {
    if (n > 0 || inventories++ == 0) return std::nullopt;
    return R"({"inverse3":[{"device_id":"049D","status":{"in_use":true}}]})";
  };
  const Service other(held);
  Client second(other.address(), {.returns = kSecond});
  CHECK_THAT(error_of([&] {
               second.until([](const DeviceSample&) { return false; }, {1, 0, 0});
             }),
             Contains("the service came back, and another program uses device 049D"));
  for (int connection = 1; connection < 10; ++connection) CHECK(other.forces_x_N(connection).empty());
}

TEST_CASE("inverse3 socket: a program that ends while its service is away does not wait for it") {
  ServiceOptions options;
  options.closes_after = 5;
  options.refuses_from = 1;
  const Service service(options);
  Client client(service.address(), {.returns = kSecond * 1000});
  CHECK(client.until([](const DeviceSample& sample) { return !sample.drivable; }));
  // If the client waited, this test would run into its time limit.
}

TEST_CASE("inverse3 socket: a service that is killed ends the run") {
  int out[2], in[2];
  REQUIRE(pipe(out) == 0);
  REQUIRE(pipe(in) == 0);
  const pid_t child = fork();
  if (child == 0) {
    dup2(out[1], STDOUT_FILENO);
    dup2(in[0], STDIN_FILENO);
    close(in[1]);  // so that the input of the child ends when this process ends
    execl(EVENSTEP_INVERSE3_SERVICE, EVENSTEP_INVERSE3_SERVICE, static_cast<char*>(nullptr));
    _exit(127);
  }
  char line[64] = {};
  REQUIRE(read(out[0], line, sizeof line - 1) > 10);
  const std::string address(line, std::string(line).find('\n'));
  Client client(address);
  CHECK(client.until([](const DeviceSample& sample) { return sample.fresh; }));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  CHECK_THAT(error_of([&] { client.until([](const DeviceSample&) { return false; }); }),
             Contains("the connection was closed"));
  for (const int end : {out[0], out[1], in[0], in[1]}) close(end);
}

TEST_CASE(
    "inverse3 socket: messages that are no JSON, of another shape, or not text are counted or skipped, and the run goes "
    "on") {
  const char* const wrong[] = {"{",
                               R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":NaN,"y":0,"z":0}}}]})",
                               R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":1}}}]})",
                               R"({"inverse3":{"049D":{}}})", "[[[[[[[["};
  const Service service(saying([&](int n) -> std::optional<std::string> {
    if (n > 0 && n % 2 == 0) return wrong[n / 2 % 5];
    return std::nullopt;
  }));
  Client client(service.address());
  CHECK(client.until([&](const DeviceSample&) {
    return client.driver.counters().malformed >= 5 && client.driver.counters().reports >= 5;
  }));

  ServiceOptions bytes;
  bytes.binary = true;
  const Service binary(bytes);
  Client other(binary.address());
  for (int i = 0; i < 50; ++i) {
    CHECK_FALSE(other.driver.read(other.clock.now()).fresh);
    sleep_ms(1);
  }
}

TEST_CASE("inverse3 socket: a first message that is none is refused with what is wrong with it") {
  const Service broken(saying([](int n) { return n == 0 ? std::optional<std::string>("{\x1b[2J") : std::nullopt; }));
  CHECK_THAT(refusal(broken.address()), Contains("not what an Inverse Service says: no JSON at byte 2"));
  CHECK(inverse3_devices(*read_inverse3_address(broken.address())).empty());
  const Service bare(saying([](int) { return "{}"; }));
  CHECK_THAT(refusal(bare.address()), Contains("no Inverse3 is connected"));
}

TEST_CASE("inverse3 socket: a message longer than the limit ends the connection, before it is all there") {
  const Service service(saying(
      [](int n) { return n == 3 ? std::optional<std::string>(std::string(std::size_t{64} << 20, ' ')) : std::nullopt; }));
  Client client(service.address());
  CHECK_THAT(error_of([&] { client.until([](const DeviceSample&) { return false; }); }),
             Contains("a message of more than 65536 bytes"));
}

TEST_CASE("inverse3 socket: while a late service answers no read waits, and the newest force is what it gets next") {
  ServiceOptions options;
  options.late = Duration{60'000'000};
  const Service service(options);
  Client client(service.address(), {.hold = kSecond});
  int fresh = 0, slow = 0;
  const RealTime began = client.clock.now();
  for (int i = 1; i <= 300; ++i) {
    const RealTime before = client.clock.now();
    fresh += client.driver.read(before).fresh;
    client.driver.write({i * 1e-3, 0, 0});
    slow += client.clock.now() - before > Duration{30'000'000};
    sleep_ms(1);
  }
  const std::int64_t answers = (client.clock.now() - began).ns / options.late.ns + 2;
  CHECK(slow <= 30);  // a busy machine stops this thread now and then; a read that waits takes 60 ms each time
  CHECK(fresh >= 1);
  CHECK(fresh <= answers);
  const std::vector<double> forces = service.forces_x_N();
  CHECK(static_cast<std::int64_t>(forces.size()) <= answers);
  CHECK(std::is_sorted(forces.begin(), forces.end()));
  CHECK(client.socket.times().overtaken >= 300 - answers);
}

TEST_CASE("inverse3 socket: a service that falls silent is asked again, and its hand counts as not reported") {
  const Service service(saying([](int n) { return n >= 5 ? std::optional<std::string>("") : std::nullopt; }));
  Client client(service.address());
  CHECK(client.until([&](const DeviceSample&) { return client.socket.times().unanswered >= 2; }));
  const std::int64_t stale = client.driver.counters().stale;
  CHECK_FALSE(client.driver.read(client.clock.now()).fresh);
  CHECK(client.driver.counters().stale == stale + 1);
}

TEST_CASE("inverse3 socket: no position that is read is from the future") {
  ServiceOptions options;
  options.position_is_time = true;
  const Service service(options);
  Client client(service.address());
  int fresh = 0;
  CHECK(client.until([&](const DeviceSample& sample) {
    if (!sample.fresh) return false;
    CHECK(service.age_of(sample.position_m.x).ns >= -1);  // a time of single nanoseconds, in double precision
    return ++fresh == 50;
  }));
}

/// test_inverse3 "[.measure]" prints how long it takes from a message to its answer over this machine's loopback, and how
/// old a position is when a tick at 1 kHz reads it, both for new samples and for all samples that a tick uses.
TEST_CASE("inverse3 socket: round trips and ages over loopback", "[.measure]") {
  ServiceOptions options;
  options.position_is_time = true;
  const Service service(options);
  for (const std::int64_t rate : {1000, 2000, 4000}) {
    Client client(service.address(), {.update_rate = {rate, 1}});
    REQUIRE(client.until([](const DeviceSample& sample) { return sample.fresh; }));
    const double cpu_s = process_cpu_seconds();
    DurationHistogram fresh, all;
    const RealTime begin = client.clock.now();
    for (std::int64_t tick = 1; tick <= 5000; ++tick) {
      client.clock.wait_until(begin + Duration{tick * 1'000'000});
      const DeviceSample sample = client.driver.read(client.clock.now());
      const Duration age = service.age_of(sample.position_m.x);
      if (sample.fresh) fresh.add(age);
      all.add(age);
      client.driver.write(glm::dvec3(0));
    }
    const Inverse3Times times = client.socket.times();
    const auto us = [](const DurationHistogram& of) {
      const auto one = [](Duration duration) { return std::to_string(duration.ns / 1000); };
      return "p50 " + one(of.quantile(500)) + ", p99 " + one(of.quantile(990)) + ", max " + one(of.largest()) + " us";
    };
    std::printf(
        "%lld Hz asked: %lld answers in 5 s, %s; age of %lld new samples of 5000 ticks: %s; of all: %s; %.2f s of "
        "processor\n",
        static_cast<long long>(rate), static_cast<long long>(times.answered.count()), us(times.answered).c_str(),
        static_cast<long long>(fresh.count()), us(fresh).c_str(), us(all).c_str(), process_cpu_seconds() - cpu_s);
  }
}
