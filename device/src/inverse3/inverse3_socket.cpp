#include "evenstep/device/inverse3/inverse3_socket.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/looked_for.h"

namespace evenstep {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::system::error_code;

constexpr Duration kLost{100'000'000};  // an answer that takes longer is taken as lost
constexpr std::chrono::milliseconds kFarewell{250};
constexpr Duration kListing{250'000'000};
constexpr std::chrono::seconds kAttempt{2};

std::chrono::nanoseconds of(Duration duration) { return std::chrono::nanoseconds(duration.ns); }

}  // namespace

/// Members that only the thread of `io` uses have no lock; `mutex` guards those that both sides use.
struct Inverse3Socket::State {
  State(const Inverse3Address& where, const WallClock& with, const Inverse3SocketOptions& how)
      : address(where), clock(with), options(how), outbox(inverse3_inventory_message(), how.hold) {}

  void open();
  void connect();
  void connected(error_code error);
  void shaken(error_code error);
  void receive();
  void received(error_code error);
  void schedule();
  void send_due();
  void sent(error_code error);
  void say_goodbye();
  void end(const std::string& why);
  bool look_again(const std::string& why);
  [[noreturn]] void refuse(const std::string& why) const { throw DeviceError(address.text + ": " + why); }

  const Inverse3Address address;
  const WallClock& clock;
  const Inverse3SocketOptions options;

  asio::io_context io{1};
  std::optional<websocket::stream<beast::tcp_stream>> socket;
  asio::steady_timer next_send{io}, farewell{io}, retry{io};
  beast::flat_buffer incoming{kLongestInverse3Message + 1024};  // a whole message, and the beginning of the next
  std::string outgoing, doing;
  bool is_up = false;    // from connect() until end()
  bool is_open = false;  // open() has returned
  bool has_first = false, writing = false, closing = false, farewell_sent = false;
  std::optional<RealTime> asked_at;  // a message that is not answered yet

  std::mutex mutex;
  Inverse3Outbox outbox;
  std::string newest, why_gone;
  std::string first, arrived;  // first message of the connection in use; of the returned one
  bool has_newest = false, has_unsent = false, gone = false;
  bool accepted = false;  // rest() was called since the start or since the last connection was lost
  bool away = false, returned = false;
  RealTime lost_at;
  Inverse3Times times;

  std::thread thread;
};

// ---- the connection

/// Runs until the first message is there.
void Inverse3Socket::State::open() {
  connect();
  io.run_for(of(options.patience));
  if (!gone && !has_first) refuse(fmt::format("{} (waited {:.3g} s)", doing, seconds(options.patience)));
  if (gone) refuse(why_gone);
  first = newest;
  is_open = true;
}

void Inverse3Socket::State::connect() {
  socket.emplace(io);
  incoming.clear();
  is_up = true;
  has_first = writing = false;
  asked_at.reset();
  doing = "no connection: is the Inverse Service running?";
  error_code error;
  const auto host = asio::ip::make_address(address.host, error);
  if (error) return end("no address: " + error.message());
  if (away) socket->next_layer().expires_after(kAttempt);
  socket->next_layer().async_connect({host, static_cast<unsigned short>(address.port)},
                                     [this](error_code result) { connected(result); });
}

void Inverse3Socket::State::connected(error_code error) {
  if (!is_up) return;
  if (error) return end(doing + " (" + error.message() + ")");
  doing = "connected, but it does not answer as a WebSocket";
  socket->next_layer().socket().set_option(asio::ip::tcp::no_delay(true), error);
  socket->read_message_max(kLongestInverse3Message);
  socket->async_handshake(fmt::format("{}:{}", address.host, address.port), "/",
                          [this](error_code result) { shaken(result); });
}

void Inverse3Socket::State::shaken(error_code error) {
  if (!is_up) return;
  if (error) return end(doing + " (" + error.message() + ")");
  doing = "it says nothing";
  receive();
  send_due();
}

void Inverse3Socket::State::receive() {
  socket->async_read(incoming, [this](error_code error, std::size_t) { received(error); });
}

void Inverse3Socket::State::received(error_code error) {
  if (!is_up) return;
  if (error == websocket::error::message_too_big || error == websocket::error::buffer_overflow)
    return end(fmt::format("it sent a message of more than {} bytes", kLongestInverse3Message));
  if (error) return end("the connection was closed (" + error.message() + ")");
  const bool is_first = !has_first && socket->got_text();
  if (socket->got_text()) {
    const auto bytes = incoming.data();
    const std::lock_guard lock(mutex);
    newest.assign(static_cast<const char*>(bytes.data()), bytes.size());
    has_newest = has_first;  // first_message() gives the first one
    if (asked_at && has_first) times.answered.add(clock.now() - *asked_at);
    if (is_first && away) {
      arrived = newest;
      returned = true;
      away = false;
    }
  }
  has_first = has_first || is_first;
  asked_at.reset();
  incoming.clear();
  if (is_first) socket->next_layer().expires_never();
  receive();
  if (!is_first) return;
  if (!is_open) return io.stop();  // open() returns; the thread goes on from here
  schedule();
}

// ---- sending

void Inverse3Socket::State::schedule() {
  // A period after the last expiry, so that late wake-ups do not add up; at once if that is past.
  next_send.expires_at(
      std::max(next_send.expiry() + of(period_ceil(options.update_rate)), asio::steady_timer::clock_type::now()));
  next_send.async_wait([this](error_code error) {
    if (error || !is_up || !has_first || closing) return;
    send_due();
    schedule();
  });
}

void Inverse3Socket::State::send_due() {
  if (writing || !is_up) return;
  const RealTime now = clock.now();
  if (asked_at && now - *asked_at < kLost && !closing) return;
  {
    const std::lock_guard lock(mutex);
    if (asked_at && !closing) ++times.unanswered;
    outgoing = closing ? outbox.last() : outbox.due(now);
    has_unsent = false;
  }
  farewell_sent = closing;
  asked_at = now;
  writing = true;
  socket->text(true);
  socket->async_write(asio::buffer(outgoing), [this](error_code error, std::size_t) { sent(error); });
}

void Inverse3Socket::State::sent(error_code error) {
  if (!is_up) return;
  writing = false;
  if (error) return end("the connection was closed (" + error.message() + ")");
  if (!closing) return;
  if (!farewell_sent) return send_due();
  socket->async_close(websocket::close_code::normal, [this](error_code) { io.stop(); });
}

void Inverse3Socket::State::say_goodbye() {
  closing = true;
  next_send.cancel();
  retry.cancel();
  if (!is_up || !has_first) return io.stop();
  farewell.expires_after(kFarewell);
  farewell.async_wait([this](error_code) { io.stop(); });
  send_due();
}

/// Ends the connection, or an attempt to restore it. Operations still running on the socket learn of it before `retry` is
/// due.
void Inverse3Socket::State::end(const std::string& why) {
  if (!std::exchange(is_up, false)) return;
  next_send.cancel();
  error_code ignored;
  socket->next_layer().socket().close(ignored);
  if (closing || !look_again(why)) return io.stop();
  retry.expires_after(of(kLookAgain));
  retry.async_wait([this](error_code error) {
    if (!error && !closing) connect();
  });
}

/// False: the connection is gone for ever.
bool Inverse3Socket::State::look_again(const std::string& why) {
  const std::lock_guard lock(mutex);
  const RealTime now = clock.now();
  if (std::exchange(accepted, false)) {
    ++times.lost;
    lost_at = now;
  } else if (times.lost == 0) {
    gone = true;  // there never was a connection
    why_gone = why;
    return false;
  }
  away = true;
  returned = has_newest = has_unsent = false;
  outbox = Inverse3Outbox(inverse3_inventory_message(), options.hold);
  if (options.returns.ns > 0 && now - lost_at < options.returns) return true;
  gone = true;
  why_gone = options.returns.ns == 0 ? why
                                     : fmt::format("the connection was closed, and not there again within {:.3g} s: {}",
                                                   seconds(options.returns), why);
  return false;
}

// ---- what others call

Inverse3Socket::Inverse3Socket(const Inverse3Address& address, const WallClock& clock, const Inverse3SocketOptions& options)
    : state_(std::make_unique<State>(address, clock, options)) {
  if (!address.is_loopback && !options.remote)
    state_->refuse(
        "this address is not of this machine; if the service is to be reached over a network, write inverse3 = { "
        "remote = true }");
  state_->open();
  state_->io.restart();
  state_->schedule();
  state_->thread = std::thread([state = state_.get()] { state->io.run(); });
}

Inverse3Socket::~Inverse3Socket() {
  asio::post(state_->io, [state = state_.get()] { state->say_goodbye(); });
  state_->thread.join();
}

Inverse3Link::Read Inverse3Socket::read(std::string& text) {
  const std::lock_guard lock(state_->mutex);
  if (state_->gone) {
    text = state_->why_gone;
    return Read::gone;
  }
  if (state_->away) return Read::away;
  if (std::exchange(state_->returned, false)) {
    state_->first = std::move(state_->arrived);
    return Read::returned;
  }
  if (!std::exchange(state_->has_newest, false)) return Read::nothing;
  std::swap(text, state_->newest);
  return Read::message;
}

void Inverse3Socket::post(std::string text) {
  const RealTime now = state_->clock.now();
  const std::lock_guard lock(state_->mutex);
  if (state_->away || state_->returned) return;  // a force is not meant for the next connection
  state_->times.overtaken += state_->has_unsent;
  state_->has_unsent = true;
  state_->outbox.post(std::move(text), now);
}

void Inverse3Socket::rest(std::string text) {
  const std::lock_guard lock(state_->mutex);
  state_->outbox.rest(std::move(text));
  state_->accepted = state_->accepted || !state_->away;
}

void Inverse3Socket::reject(std::string why) {
  asio::post(state_->io, [state = state_.get(), text = std::move(why)] { state->end(text); });
}

const std::string& Inverse3Socket::first_message() const { return state_->first; }
const std::string& Inverse3Socket::name() const { return state_->address.text; }

Inverse3Times Inverse3Socket::times() const {
  const std::lock_guard lock(state_->mutex);
  return state_->times;
}

bool built_with_inverse3() { return true; }

std::vector<Inverse3State> inverse3_devices(const Inverse3Address& address) {
  const WallClock clock(WallEpoch::in(Duration{}));
  try {
    // Remote addresses too: the user named this one, and a listing sends no force.
    const Inverse3Socket service(address, clock, {.patience = kListing, .remote = true});
    return read_inverse3_message(service.first_message()).value_or({});
  } catch (const DeviceError&) {
    return {};
  }
}

}  // namespace evenstep
