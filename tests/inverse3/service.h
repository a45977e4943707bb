#pragma once
// A Haply Inverse Service of ours on a port of this machine, with a simulated hand behind it, and with faults. It was
// written from other clients than the driver (docs/inverse3.md): it says what those read, and takes what those send.

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
  bool first = true;      // false: a WebSocket that does not begin with an inventory, nor answers
  int refuses_from = 99;  // connections after so many are refused with the HTTP status 503
  std::function<bool(int connection)> refuses;  // and those of which this is true
  /// What is said instead of the n-th answer, counted from 0 (the inventory); empty: nothing; std::nullopt: what is true.
  std::function<std::optional<std::string>(int n)> instead;
  bool binary = false;
  int closes_after = -1;  // so many answers
  int closes = 99;        // so many connections, the first ones
  /// The device that connections from the second on are told of; empty: the same.
  std::string returns_as;
  bool position_is_time = false;  // x is 1 mm for each second of age_of(), and no hand
};

class Service {
 public:
  explicit Service(ServiceOptions options = {});
  ~Service();
  std::string address() const;                           // ws://127.0.0.1:PORT
  glm::dvec3 force_N() const;                            // what the hand feels now
  std::vector<double> forces_x_N() const;                // all that came, in their order
  std::vector<double> forces_x_N(int connection) const;  // counted from 0
  Duration age_of(double x_m) const;                     // now, of a position that is a time
  int messages() const;                                  // that came
  int inventories_asked() const;

  struct State;

 private:
  std::unique_ptr<State> state_;
};

}  // namespace evenstep::test
