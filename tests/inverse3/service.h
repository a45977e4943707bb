#pragma once
// A simulated Haply Inverse Service on a port of this machine, with a simulated hand behind it, and with faults. It was
// written after other clients than the driver (docs/devices/inverse3.md): it sends what those read and accepts what those
// send.

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep::test {

struct ServiceOptions {
  std::string device_id = "049D";
  bool in_use = false;
  Duration late;          // before each answer
  bool speaks = true;     // false: it accepts the connection and says nothing, not even that it is a WebSocket
  bool first = true;      // false: a WebSocket that neither begins with an inventory nor answers
  int refuses_from = 99;  // after this many connections, others are refused with the HTTP status 503
  std::function<bool(int connection)> refuses;  // connections for which this is true are refused as well
  /// What is sent instead of answer n, counted from 0 (the inventory). Empty: nothing; std::nullopt: the true answer.
  std::function<std::optional<std::string>(int n)> instead;
  bool binary = false;
  int closes_after = -1;  // closes a connection after this many answers
  int closes = 99;        // does so with this many connections, the first ones
  /// The device of which connections from the second on are told; empty: the same device.
  std::string returns_as;
  bool position_is_time = false;  // x is 1 mm for each second of age_of(), and no hand
};

class Service {
 public:
  explicit Service(ServiceOptions options = {});
  ~Service();
  std::string address() const;                           // ws://127.0.0.1:PORT
  glm::dvec3 force_N() const;                            // the force that the hand feels now
  std::vector<double> forces_x_N() const;                // all forces that came, in order
  std::vector<double> forces_x_N(int connection) const;  // counted from 0
  Duration age_of(double x_m) const;                     // the age of a position that is a time
  int messages() const;                                  // the number of messages that came
  int inventories_asked() const;

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace evenstep::test
