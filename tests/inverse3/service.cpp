#include "service.h"

#include <sys/socket.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <list>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/hand.h"

namespace evenstep::test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using Json = nlohmann::ordered_json;

constexpr double kTime_m_per_s = 1e-3;

Json vec(const glm::dvec3& v) { return {{"x", v.x}, {"y", v.y}, {"z", v.z}}; }

}  // namespace

struct Service::State {
  explicit State(ServiceOptions with) : options(std::move(with)), acceptor(io, {asio::ip::make_address("127.0.0.1"), 0}) {
    thread = std::thread([this] { accept(); });
  }
  ~State() {
    stopping = true;
    ::shutdown(acceptor.native_handle(), SHUT_RDWR);
    {
      const std::lock_guard lock(mutex);
      for (const int socket : sockets) ::shutdown(socket, SHUT_RDWR);
    }
    thread.join();
    for (std::thread& session : sessions) session.join();
  }

  void accept() {
    for (int n = 0; !stopping; ++n) {
      boost::system::error_code error;
      tcp::socket socket = acceptor.accept(error);
      if (error) return;
      socket.set_option(tcp::no_delay(true));
      const std::lock_guard lock(mutex);
      sockets.push_back(socket.native_handle());
      sessions.emplace_back([this, n, peer = std::move(socket)]() mutable { serve(std::move(peer), n); });
    }
  }

  void serve(tcp::socket peer, int n) {
    try {
      if (!options.speaks) return wait_for_end(peer);
      if (n >= options.refuses_from || (options.refuses && options.refuses(n))) {
        beast::flat_buffer buffer;
        beast::http::request<beast::http::string_body> request;
        beast::http::read(peer, buffer, request);
        beast::http::response<beast::http::empty_body> refusal{beast::http::status::service_unavailable, 11};
        beast::http::write(peer, refusal);
        return;
      }
      beast::websocket::stream<tcp::socket&> socket(peer);
      socket.accept();
      if (options.first) say(socket, 0, n);
      for (int answer = 1; !stopping; ++answer) {
        beast::flat_buffer buffer;
        socket.read(buffer);
        hear(beast::buffers_to_string(buffer.data()), n);
        if (options.late.ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(options.late.ns));
        if (answer - 1 == options.closes_after && n < options.closes)
          return socket.close(beast::websocket::close_code::going_away);
        if (options.first) say(socket, answer, n);
      }
    } catch (const boost::system::system_error&) {  // the client has gone
    }
  }

  void wait_for_end(tcp::socket& peer) {
    boost::system::error_code error;
    std::array<char, 256> ignored;
    while (!error) peer.read_some(asio::buffer(ignored), error);
  }

  std::string device_id(int n) const {
    return n > 0 && !options.returns_as.empty() ? options.returns_as : options.device_id;
  }

  void say(beast::websocket::stream<tcp::socket&>& socket, int answer, int n) {
    std::optional<std::string> text;
    if (options.instead) text = options.instead(answer);
    if (text && text->empty()) return;
    socket.text(!options.binary || answer == 0);
    socket.write(asio::buffer(text ? *text : state(answer == 0, n)));
  }

  std::string state(bool whole, int n) {
    const std::lock_guard lock(mutex);
    Json device{{"device_id", device_id(n)}};
    const glm::dvec3 position_m = options.position_is_time
                                      ? glm::dvec3(seconds(clock.now() - RealTime{}) * kTime_m_per_s, 0, 0)
                                      : hand.position_m(clock.now());
    if (whole) device["config"] = {{"handedness", "right"}, {"port", "COM12"}};
    device["state"] = {{"cursor_position", vec(position_m)}, {"cursor_velocity", vec(glm::dvec3(0))}};
    device["status"] = {{"calibrated", true}, {"in_use", options.in_use}, {"power_supply", true}};
    return Json{{"inverse3", Json::array({device})}, {"wireless_verse_grip", Json::array()}}.dump();
  }

  void hear(const std::string& text, int n) {
    const Json message = Json::parse(text);
    const std::lock_guard lock(mutex);
    ++messages;
    if (message.contains("session")) inventories += message["session"].contains("force_render_full_state");
    if (!message.contains("inverse3")) return;
    const Json& device = message["inverse3"].at(0);
    if (device.at("device_id") != device_id(n)) return;
    const Json& values = device.at("commands").at("set_cursor_force").at("values");
    force_N = {values.at("x"), values.at("y"), values.at("z")};
    forces_x_N.emplace_back(n, force_N.x);
    hand.feel(clock.now(), force_N);
  }

  ServiceOptions options;
  asio::io_context io;
  tcp::acceptor acceptor;
  std::atomic<bool> stopping{false};
  std::thread thread;
  mutable std::mutex mutex;
  std::list<std::thread> sessions;
  std::vector<int> sockets;
  WallClock clock{WallEpoch::in(Duration{})};
  Hand hand{HandSpec{.mass_kg = 0.2, .damping_N_s_per_m = 2, .stiffness_N_per_m = 200}, ProgrammedMotion{Still{}, {}}};
  glm::dvec3 force_N{0};
  std::vector<std::pair<int, double>> forces_x_N;  // the number of the connection, and the force
  int messages = 0, inventories = 0;
};

Service::Service(ServiceOptions options) : state_(std::make_unique<State>(std::move(options))) {}
Service::~Service() = default;
std::string Service::address() const { return "ws://127.0.0.1:" + std::to_string(state_->acceptor.local_endpoint().port()); }
glm::dvec3 Service::force_N() const {
  const std::lock_guard lock(state_->mutex);
  return state_->force_N;
}
std::vector<double> Service::forces_x_N() const {
  std::vector<double> forces_N;
  const std::lock_guard lock(state_->mutex);
  for (const auto& [connection, force_N] : state_->forces_x_N) forces_N.push_back(force_N);
  return forces_N;
}
std::vector<double> Service::forces_x_N(int connection) const {
  std::vector<double> forces_N;
  const std::lock_guard lock(state_->mutex);
  for (const auto& [n, force_N] : state_->forces_x_N) {
    if (n == connection) forces_N.push_back(force_N);
  }
  return forces_N;
}
Duration Service::age_of(double x_m) const {
  return state_->clock.now() - RealTime{} - Duration{static_cast<std::int64_t>(x_m / kTime_m_per_s * 1e9)};
}
int Service::messages() const {
  const std::lock_guard lock(state_->mutex);
  return state_->messages;
}
int Service::inventories_asked() const {
  const std::lock_guard lock(state_->mutex);
  return state_->inventories;
}

}  // namespace evenstep::test
