#include "scope_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <cerrno>
#include <deque>
#include <list>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/scheduler/live_lanes.h"

namespace evenstep::app {
namespace {

namespace http = boost::beast::http;

constexpr std::size_t kMostConnections = 32;  // a further one takes the place of the oldest that is no stream
constexpr std::size_t kLongestRequest = 8192;
constexpr double kStalledSeconds = 10;  // a stream that takes nothing for so long has no reader
constexpr double kGraceSeconds = 0.5;   // for streams to take their last events
constexpr int kLookMilliseconds = 100;  // how often deadlines are looked at
constexpr int kSendBuffer = 65536;      // bytes in the kernel for a slow reader

/// A file descriptor that is closed once.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  int get() const { return number_; }

 private:
  int number_;
};

std::string error_text(int number) { return std::generic_category().message(number); }

/// 128 random bits, in hex.
std::optional<std::string> random_token() {
  std::array<unsigned char, 16> bytes;
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return std::nullopt;
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

/// Takes the same time wherever they differ.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

using Event = std::shared_ptr<const std::string>;

struct Connection {
  enum class State {
    request,  ///< it is still to be read
    answer,   ///< what is in `out` is sent, and then no more
    stream,   ///< events are sent as they come
    closing,  ///< all is sent; what still comes is read, because closing would otherwise take the answer back
  };
  explicit Connection(Descriptor accepted) : socket(std::move(accepted)) {}

  Descriptor socket;
  State state = State::request;
  double deadline_s = 0;
  http::request_parser<http::empty_body> parser;
  std::string in;
  std::string out;
  std::size_t sent = 0;  ///< of `out`
  std::deque<Event> waiting;
  std::uint64_t dropped = 0;  ///< since the reader was last told
  bool broken = false;
};

class Server final : public ScopeServer {
 public:
  Server(Descriptor listening, Descriptor wake, std::uint16_t port, std::string token, const ScopeServerOptions& options)
      : listening_(std::move(listening)),
        wake_(std::move(wake)),
        token_(std::move(token)),
        hosts_{fmt::format("127.0.0.1:{}", port), fmt::format("localhost:{}", port)},
        url_(fmt::format("http://{}/?token={}", hosts_[0], token_)),
        options_(options),
        thread_([this] { serve(); }) {}
  ~Server() override {
    stopping_ = true;
    wake();
    thread_.join();
  }
  const std::string& url() const override { return url_; }
  void publish(const std::string& name, const std::string& data) override;
  ScopeCounts counts() const override { return {streams_, opened_, refused_, dropped_}; }

 private:
  void wake() const {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(wake_.get(), &one, sizeof one);  // if it is full, it wakes all the same
  }
  void serve();
  bool wait();
  void accept_all();
  void hand_out();
  void look_at(Connection& connection, short events);
  void read_request(Connection& connection);
  void answer(Connection& connection);
  int status_of(const http::request<http::empty_body>& request) const;
  void refuse(Connection& connection, int status);
  void send(Connection& connection);
  void next_event(Connection& connection);
  std::string head(std::string_view status, std::string_view type, const std::string& more) const;

  Descriptor listening_, wake_;
  std::string token_;
  std::array<std::string, 2> hosts_;
  std::string url_;
  ScopeServerOptions options_;
  std::list<Connection> connections_;  // the thread's own
  std::vector<pollfd> polled_;         // the thread's own

  std::mutex mutex_;
  std::vector<Event> published_;  // guarded by mutex_
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint64_t> streams_{0}, opened_{0}, refused_{0}, dropped_{0};
  LaneThread thread_;  // last, because it begins here
};

void Server::publish(const std::string& name, const std::string& data) {
  Event event = std::make_shared<const std::string>(fmt::format("event: {}\ndata: {}\n\n", name, data));
  {
    const std::lock_guard lock(mutex_);  // the other side holds it for the time of a swap
    if (published_.size() == kMostWaiting) {
      ++dropped_;
      return;
    }
    published_.push_back(std::move(event));
  }
  wake();
}

void Server::serve() {
  leave_real_time();
  std::optional<double> stop_at_s;
  for (;;) {
    if (stopping_ && !stop_at_s) stop_at_s = monotonic_seconds() + kGraceSeconds;
    hand_out();
    for (Connection& connection : connections_) {
      if (connection.state == Connection::State::stream) send(connection);
      connection.broken |= monotonic_seconds() > connection.deadline_s;
    }
    connections_.remove_if([](const Connection& connection) { return connection.broken; });
    streams_ = 0;
    bool unread = false;
    for (const Connection& connection : connections_) {
      streams_ += connection.state == Connection::State::stream;
      unread |= !connection.waiting.empty() || connection.sent < connection.out.size();
    }
    if (stop_at_s && (!unread || monotonic_seconds() > *stop_at_s)) return;
    if (wait()) accept_all();
  }
}

/// Looks at what has happened; returns whether somebody wants to connect.
bool Server::wait() {
  polled_ = {{wake_.get(), POLLIN, 0}};
  polled_.push_back({stopping_ ? -1 : listening_.get(), POLLIN, 0});
  for (const Connection& connection : connections_) {
    const bool to_send = connection.sent < connection.out.size();
    polled_.push_back({connection.socket.get(), static_cast<short>(POLLIN | (to_send ? POLLOUT : 0)), 0});
  }
  ::poll(polled_.data(), polled_.size(), kLookMilliseconds);
  std::uint64_t count_of_wakes;
  while (polled_[0].revents != 0 && ::read(wake_.get(), &count_of_wakes, sizeof count_of_wakes) > 0) continue;
  std::size_t at = 2;
  for (Connection& connection : connections_) {
    if (const short events = polled_[at++].revents) look_at(connection, events);
  }
  return polled_[1].revents != 0;
}

void Server::accept_all() {
  for (std::size_t n = 0; n < kMostConnections; ++n) {
    Descriptor socket(::accept4(listening_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (socket.get() < 0) return;
    ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
    // There are fewer streams than places. Whoever leaves requests half done keeps nobody out.
    if (connections_.size() == kMostConnections)
      connections_.erase(std::find_if(connections_.begin(), connections_.end(), [](const Connection& connection) {
        return connection.state != Connection::State::stream;
      }));
    Connection& connection = connections_.emplace_back(std::move(socket));
    connection.deadline_s = monotonic_seconds() + options_.request_s;
    connection.parser.header_limit(kLongestRequest);
  }
}

void Server::hand_out() {
  std::vector<Event> events;
  {
    const std::lock_guard lock(mutex_);
    events.swap(published_);
  }
  for (Connection& connection : connections_) {
    if (connection.state != Connection::State::stream) continue;
    for (const Event& event : events) {
      if (connection.waiting.size() < kMostWaiting) {
        connection.waiting.push_back(event);
      } else {
        ++connection.dropped;
        ++dropped_;
      }
    }
  }
}

void Server::look_at(Connection& connection, short events) {
  if ((events & POLLIN) != 0 && connection.state == Connection::State::request) {
    read_request(connection);
  } else if ((events & POLLIN) != 0) {  // nothing more is expected; 0: the reader has left
    std::array<char, 4096> ignored;
    const ssize_t count = ::recv(connection.socket.get(), ignored.data(), ignored.size(), 0);
    connection.broken |= count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR);
  } else if ((events & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
    connection.broken = true;
  }
  send(connection);
}

void Server::read_request(Connection& connection) {
  std::array<char, 4096> bytes;
  const ssize_t count = ::recv(connection.socket.get(), bytes.data(), bytes.size(), 0);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) {
    connection.broken = true;
    return;
  }
  connection.in.append(bytes.data(), static_cast<std::size_t>(count));
  boost::system::error_code error;
  while (!connection.in.empty() && !connection.parser.is_header_done() && !error)
    connection.in.erase(0, connection.parser.put(boost::asio::buffer(connection.in), error));
  if (connection.parser.is_header_done()) return answer(connection);
  if (error == http::error::need_more && connection.in.size() < kLongestRequest) return;
  refuse(connection, error == http::error::header_limit || error == http::error::need_more ? 431 : 400);
}

std::string Server::head(std::string_view status, std::string_view type, const std::string& more) const {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}; charset=utf-8\r\nContent-Security-Policy: {}; frame-ancestors 'none'\r\n"
      "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n"
      "Cache-Control: no-store\r\nConnection: close\r\n{}\r\n",
      status, type, options_.policy, more);
}

/// 200, or the reason to refuse it.
int Server::status_of(const http::request<http::empty_body>& request) const {
  const auto text = [](const auto& view) { return std::string_view(view.data(), view.size()); };
  const auto ours = [&](std::string_view host) { return host == hosts_[0] || host == hosts_[1]; };
  if (request.count(http::field::host) != 1 || !ours(text(request[http::field::host]))) return 403;
  if (request.count(http::field::origin) > 0) {
    std::string_view origin = text(request[http::field::origin]);
    constexpr std::string_view kScheme = "http://";
    if (request.count(http::field::origin) > 1 || !origin.starts_with(kScheme) || !ours(origin.substr(kScheme.size())))
      return 403;
  }
  if (request.method() != http::verb::get) return 405;
  const std::string_view target = text(request.target());
  const std::size_t query = target.find('?');
  constexpr std::string_view kKey = "?token=";
  const std::string_view given = query < target.size() ? target.substr(query) : std::string_view();
  if (!given.starts_with(kKey) || !same_secret(given.substr(kKey.size()), token_)) return 403;
  const std::string_view path = target.substr(0, query);
  if (path == "/") return 200;
  if (path != "/events") return 404;
  return streams_ < kMostStreams ? 200 : 503;
}

void Server::answer(Connection& connection) {
  const http::request<http::empty_body>& request = connection.parser.get();
  const int status = status_of(request);
  if (status != 200) return refuse(connection, status);
  const bool stream = request.target().starts_with("/events");
  connection.state = stream ? Connection::State::stream : Connection::State::answer;
  if (!stream) {
    connection.out =
        head("200 OK", "text/html", fmt::format("Content-Length: {}\r\n", options_.page.size())) + options_.page;
    return;
  }
  ++streams_;
  ++opened_;
  connection.deadline_s = monotonic_seconds() + kStalledSeconds;
  connection.out = head("200 OK", "text/event-stream", "") + "retry: 1000\n\n";
}

void Server::refuse(Connection& connection, int status) {
  constexpr std::array kReasons{std::pair{400, "Bad Request"},
                                std::pair{403, "Forbidden"},
                                std::pair{404, "Not Found"},
                                std::pair{405, "Method Not Allowed"},
                                std::pair{431, "Request Header Fields Too Large"},
                                std::pair{503, "Service Unavailable"}};
  const char* reason = "";
  for (const auto& [code, words] : kReasons) reason = code == status ? words : reason;
  const std::string body = fmt::format("{}\n", reason);
  ++refused_;
  connection.state = Connection::State::answer;
  connection.out =
      head(fmt::format("{} {}", status, reason), "text/plain", fmt::format("Content-Length: {}\r\n", body.size()));
  connection.out += body;
}

/// Makes the next event of a stream what is sent.
void Server::next_event(Connection& connection) {
  if (connection.state != Connection::State::stream || connection.sent < connection.out.size()) return;
  connection.out.clear();
  connection.sent = 0;
  if (connection.waiting.empty()) {
    connection.deadline_s = monotonic_seconds() + kStalledSeconds;
    return;
  }
  if (connection.dropped > 0)
    connection.out = fmt::format("event: dropped\ndata: {}\n\n", std::exchange(connection.dropped, 0));
  connection.out += *connection.waiting.front();
  connection.waiting.pop_front();
}

void Server::send(Connection& connection) {
  for (next_event(connection); connection.sent < connection.out.size(); next_event(connection)) {
    const std::string_view rest = std::string_view(connection.out).substr(connection.sent);
    const ssize_t count = ::send(connection.socket.get(), rest.data(), rest.size(), MSG_NOSIGNAL);
    if (count < 0) {
      connection.broken |= errno != EAGAIN && errno != EINTR;
      return;
    }
    connection.sent += static_cast<std::size_t>(count);
    if (connection.state == Connection::State::stream) connection.deadline_s = monotonic_seconds() + kStalledSeconds;
  }
  if (connection.state != Connection::State::answer) return;
  connection.state = Connection::State::closing;
  ::shutdown(connection.socket.get(), SHUT_WR);
}

}  // namespace

bool built_with_scope() { return true; }

Result<std::unique_ptr<ScopeServer>, std::string> open_scope_server(const ScopeServerOptions& options) {
  Descriptor listening(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  Descriptor wake(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (listening.get() < 0 || wake.get() < 0) return Failure{"no socket: " + error_text(errno)};
  const int on = 1;
  ::setsockopt(listening.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(options.port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (::bind(listening.get(), generic, size) != 0 || ::listen(listening.get(), 16) != 0 ||
      ::getsockname(listening.get(), generic, &size) != 0)
    return Failure{fmt::format("port {} of this machine: {}; leave --scope-port out for one that is free", options.port,
                               error_text(errno))};
  std::optional<std::string> token = random_token();
  if (!token) return Failure{std::string("the system has no random numbers: " + error_text(errno))};
  return std::unique_ptr<ScopeServer>(
      std::make_unique<Server>(std::move(listening), std::move(wake), ntohs(address.sin_port), std::move(*token), options));
}

}  // namespace evenstep::app
