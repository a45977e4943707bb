#pragma once
/// A connection to a Haply Inverse Service over a WebSocket. No other code opens one. A thread of its own sends what is due,
/// takes the answers, and keeps the newest: no caller waits for the service. It works with a wall clock only.
///
/// The next message is sent when the last one was answered, at the earliest a period of `update_rate` after it. An answer
/// that has not come after 100 ms counts as lost. Forces that a newer one replaces are not sent.
///
/// A connection that has ended is tried again four times a second for `returns`; what was posted before is never sent to the
/// new one.
///
/// Without Boost.Beast (EVENSTEP_INVERSE3) the constructor throws and the list is empty.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/inverse3/inverse3_link.h"
#include "evenstep/device/inverse3/inverse3_messages.h"
#include "evenstep/time/duration_histogram.h"

namespace evenstep {

struct Inverse3SocketOptions {
  Rate update_rate{2000, 1};
  Duration hold{100'000'000};        ///< this long after the last post the link sends what rest() gave
  Duration patience{2'000'000'000};  ///< for the connection and the first message, together
  Duration returns{0};               ///< how long a connection that has ended is tried again; 0: it is gone at once
  bool remote = false;               ///< allow an address of another machine
};

/// What became of the messages that were sent.
struct Inverse3Times {
  DurationHistogram answered;   ///< from the sending of a message to the next one that came
  std::int64_t overtaken = 0;   ///< forces that a newer one replaced before they were sent
  std::int64_t unanswered = 0;  ///< messages without an answer within 100 ms
  std::int64_t lost = 0;        ///< connections that have ended
};

class Inverse3Socket final : public Inverse3Link {
 public:
  /// Connects and takes the first message. Throws DeviceError, with the remedy, if there is no service, it says nothing in
  /// time, it refuses, or the address is of another machine and `remote` is not set.
  Inverse3Socket(const Inverse3Address& address, const WallClock& clock, const Inverse3SocketOptions& options);
  /// Sends what rest() gave, and closes the connection; takes at most a quarter of a second.
  ~Inverse3Socket() override;

  Read read(std::string& text) override;
  void post(std::string text) override;
  void rest(std::string text) override;
  void reject(std::string why) override;
  const std::string& first_message() const override;
  const std::string& name() const override;

  Inverse3Times times() const;  ///< so far; callable from any thread

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether this evenstep can talk to a service at all (EVENSTEP_INVERSE3).
bool built_with_inverse3();

/// The devices of the service at the address, without taking one. None if nobody listens there, nothing is said within a
/// quarter of a second, or it is not an Inverse Service. If nobody listens it does not wait.
std::vector<Inverse3State> inverse3_devices(const Inverse3Address& address);

}  // namespace evenstep
