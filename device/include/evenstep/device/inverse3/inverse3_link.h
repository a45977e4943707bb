#pragma once
/// A connection to a Haply Inverse Service, as its driver sees it: the newest message that has come, and what is to be sent.
/// The driver lies above this interface; below it are the socket (inverse3_socket.h) and a simulated service.
///
/// The service answers every message with one of its own, and says nothing unasked. So the link sends all the time, at a
/// rate of its own: the newest text that was posted or, if nothing was posted for a while, the text given to rest(). Thus a
/// program that hangs pushes nobody.

#include <string>
#include <utility>

#include "evenstep/time/time.h"

namespace evenstep {

class Inverse3Link {
 public:
  enum class Read { message, nothing, away, returned, gone };
  virtual ~Inverse3Link() = default;
  /// The newest message since the last call; those before it are dropped. `away`: the connection has ended, and a new one is
  /// tried. `returned`: once after that; first_message() is that of the new connection, nothing is posted, and the caller
  /// has to call rest() again, or reject(). `gone`: the connection has ended, for ever, and `text` says why. Never waits.
  virtual Read read(std::string& text) = 0;
  /// What has returned is not what was lost: the connection is closed, and another one is tried for the time that is left.
  /// Never waits.
  virtual void reject(std::string /*why*/) {}
  /// What is sent from now on. Never waits.
  virtual void post(std::string text) = 0;
  /// What is sent if nothing was posted for `hold` (an option of the link), and as the very last message. Until this is
  /// called, that is the message that asks for all devices.
  virtual void rest(std::string text) = 0;
  /// The first message of the service.
  virtual const std::string& first_message() const = 0;  ///< changes in read() alone
  virtual const std::string& name() const = 0;           ///< for errors
};

/// What a link has to send, for those who implement one. Not safe between threads.
class Inverse3Outbox {
 public:
  Inverse3Outbox(std::string rest, Duration hold) : rest_(std::move(rest)), hold_(hold) {}
  void post(std::string text, RealTime now) { posted_ = std::move(text), until_ = now + hold_; }
  void rest(std::string text) { rest_ = std::move(text), posted_.clear(); }
  const std::string& due(RealTime now) const { return posted_.empty() || now >= until_ ? rest_ : posted_; }
  const std::string& last() const { return rest_; }

 private:
  std::string rest_, posted_;
  Duration hold_;
  RealTime until_;
};

}  // namespace evenstep
