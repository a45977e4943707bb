// The server of the page as its clients see it, both friendly and hostile ones, through real sockets of this machine.

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "catch.h"
#include "src/live/scope_server.h"

using namespace evenstep::app;

namespace {

constexpr auto kPatience = std::chrono::seconds(20);  // only a server that hangs needs that long

class Client {
 public:
  explicit Client(const std::string& url, int receive_buffer = 0) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const timeval patience{kPatience.count(), 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (receive_buffer > 0) ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(url.substr(std::strlen("http://127.0.0.1:")))));
    REQUIRE(::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  }
  ~Client() { ::close(fd_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  Client& send(const std::string& text) {
    std::size_t sent = 0;
    while (sent < text.size()) {
      const ssize_t count = ::send(fd_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
      if (count <= 0) break;  // the server may have had enough of it
      sent += static_cast<std::size_t>(count);
    }
    return *this;
  }
  /// Reads until this text has come. If the text is empty, reads until the server ends the connection.
  std::string receive(const std::string& until = "") {
    std::array<char, 65536> bytes;
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while ((until.empty() || read_.find(until) == std::string::npos) && std::chrono::steady_clock::now() < end) {
      pollfd polled{fd_, POLLIN, 0};
      if (::poll(&polled, 1, 100) <= 0) continue;
      const ssize_t count = ::recv(fd_, bytes.data(), bytes.size(), 0);
      if (count <= 0) break;
      read_.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return read_;
  }

 private:
  int fd_;
  std::string read_;
};

struct Served {
  explicit Served(const std::string& page = "<p>page</p>", double request_s = 5) {
    auto opened = open_scope_server({0, page, "default-src 'none'", request_s});
    REQUIRE(opened);
    server = std::move(opened).value();
    const std::size_t slash = server->url().find('/', std::strlen("http://"));
    host = server->url().substr(std::strlen("http://"), slash - std::strlen("http://"));
    query = server->url().substr(slash + 1);
  }
  std::string get(const std::string& path, const std::string& more = "") const {
    return "GET " + path + query + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n";
  }
  /// The first line of the answer.
  std::string status(const std::string& request) const {
    Client client(server->url());
    const std::string answer = client.send(request).receive();
    return answer.substr(0, answer.find('\r'));
  }
  template <class Condition>
  bool wait_for(Condition condition) const {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!condition(server->counts()) && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return condition(server->counts());
  }
  std::unique_ptr<ScopeServer> server;
  std::string host, query;
};

constexpr const char* kOk = "HTTP/1.1 200 OK";
constexpr const char* kForbidden = "HTTP/1.1 403 Forbidden";

}  // namespace

TEST_CASE("the page is given to who has its address, with a policy and leave for nobody else") {
  const Served served;
  CHECK(served.query.size() == std::strlen("?token=") + 32);
  Client client(served.server->url());
  const std::string answer = client.send(served.get("/")).receive();
  CHECK(answer.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\n"));
  CHECK(answer.ends_with("\r\n\r\n<p>page</p>"));
  for (const char* header :
       {"Content-Security-Policy: default-src 'none'; frame-ancestors 'none'\r\n", "X-Content-Type-Options: nosniff\r\n",
        "Referrer-Policy: no-referrer\r\n", "Cross-Origin-Resource-Policy: same-origin\r\n", "Cache-Control: no-store\r\n"})
    CHECK(answer.find(header) != std::string::npos);
  CHECK(answer.find("Access-Control-Allow") == std::string::npos);
  CHECK(Served().query != served.query);
}

TEST_CASE("who lacks the token, comes by another name or from another page is refused") {
  const Served served;
  const std::string host = "Host: " + served.host + "\r\n\r\n";
  const std::string port = served.host.substr(served.host.find(':'));
  std::string wrong = served.query;
  wrong.back() = wrong.back() == '0' ? '1' : '0';
  for (const std::string& target : {std::string("/"), "/events" + wrong, "/" + served.query.substr(0, 20),
                                    "/" + served.query + "0", "/" + served.query + "&a=b", std::string("/?token=")})
    CHECK(served.status("GET " + target + " HTTP/1.1\r\n" + host) == kForbidden);
  const std::string line = "GET /" + served.query + " HTTP/1.1\r\n";
  for (const std::string& other :
       {std::string(), std::string("Host: evil.example\r\n"), "Host: evil.example" + port + "\r\n",
        std::string("Host: 127.0.0.1\r\n"), "Host: " + served.host + "\r\nHost: evil.example\r\n"})
    CHECK(served.status(line + other + "\r\n") == kForbidden);
  for (const std::string& origin : {std::string("http://evil.example"), std::string("null"), "https://" + served.host,
                                    std::string("http://127.0.0.1"), "http://" + served.host + ".evil.example"})
    CHECK(served.status(served.get("/events", "Origin: " + origin + "\r\n")) == kForbidden);
  CHECK(served.status(served.get("/", "Origin: http://" + served.host + "\r\n")) == kOk);
  CHECK(served.status("GET /" + served.query + " HTTP/1.1\r\nHost: localhost" + port + "\r\n\r\n") == kOk);
  CHECK(served.server->counts().streams == 0);
  CHECK(served.server->counts().refused == 16);
}

TEST_CASE("what is no request for the page is refused, however long") {
  const Served served;
  CHECK(served.status(served.get("/other")) == "HTTP/1.1 404 Not Found");
  CHECK(served.status("POST /" + served.query + " HTTP/1.1\r\nHost: " + served.host +
                      "\r\nContent-Length: 5\r\n\r\nhello") == "HTTP/1.1 405 Method Not Allowed");
  CHECK(served.status("no HTTP\r\n\r\n") == "HTTP/1.1 400 Bad Request");
  CHECK(served.status(served.get("/", "X: " + std::string(9000, 'x') + "\r\n")) ==
        "HTTP/1.1 431 Request Header Fields Too Large");
  CHECK(served.status(std::string(1'000'000, 'x')).starts_with("HTTP/1.1 4"));
  CHECK(served.status(served.get("/")) == kOk);
}

TEST_CASE("a hundred clients: four streams, and 503 for the others, until a stream ends") {
  const Served served;
  std::vector<std::unique_ptr<Client>> streams;
  for (int i = 0; i < 4; ++i) {
    streams.push_back(std::make_unique<Client>(served.server->url()));
    CHECK(streams.back()->send(served.get("/events")).receive("retry: 1000\n\n").starts_with(kOk));
  }
  for (int i = 4; i < 100; ++i) REQUIRE(served.status(served.get("/events")) == "HTTP/1.1 503 Service Unavailable");
  CHECK(served.status(served.get("/")) == kOk);
  served.server->publish("rows", "{}");
  for (const auto& stream : streams) CHECK(stream->receive("data: {}\n\n").ends_with("event: rows\ndata: {}\n\n"));
  streams.pop_back();
  REQUIRE(served.wait_for([](const ScopeCounts& counts) { return counts.streams == 3; }));
  Client again(served.server->url());
  CHECK(again.send(served.get("/events")).receive("retry: 1000\n\n").starts_with(kOk));
}

TEST_CASE("a reader that takes nothing loses events, which are counted and told to it, and others lose none") {
  Served served;
  Client idle(served.server->url(), 2048), reader(served.server->url());
  idle.send(served.get("/events"));
  reader.send(served.get("/events")).receive("retry: 1000\n\n");
  REQUIRE(served.wait_for([](const ScopeCounts& counts) { return counts.streams == 2; }));
  const std::string much(20'000, 'x');
  int sent = 0;
  for (; sent < 2000 && served.server->counts().dropped < 5; ++sent) {
    served.server->publish("rows", std::to_string(sent) + much);
    REQUIRE(reader.receive("data: " + std::to_string(sent) + "x").size() > 0);
  }
  CHECK(served.server->counts().dropped >= 5);
  served.server->publish("end", "");
  CHECK(reader.receive("event: end").find("event: dropped") == std::string::npos);
  for (int i = 0; i < sent; ++i)
    REQUIRE(reader.receive("end").find("data: " + std::to_string(i) + "x") != std::string::npos);
  // Now the idle client reads. It gets what was kept for it, then the number of rows that it has lost.
  REQUIRE(idle.receive("data: 0x").find("data: 0x") != std::string::npos);
  served.server->publish("rows", "last");
  CHECK(idle.receive("event: dropped\ndata: ").find("event: dropped\ndata: ") != std::string::npos);
}

TEST_CASE("a request that does not end is given up, and keeps nobody waiting") {
  const Served served;
  std::vector<std::unique_ptr<Client>> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<Client>(served.server->url()));
    slow.back()->send("GET /");
  }
  CHECK(served.status(served.get("/")) == kOk);
  CHECK(slow.front()->receive().empty());
}

TEST_CASE("sixty requests that never end keep no further reader out, and end no stream") {
  const Served served("<p>page</p>", 3600);  // so long that only room for others can end them
  Client stream(served.server->url());
  CHECK(stream.send(served.get("/events")).receive("retry: 1000\n\n").starts_with(kOk));
  std::vector<std::unique_ptr<Client>> half;
  for (int i = 0; i < 60; ++i) {
    half.push_back(std::make_unique<Client>(served.server->url()));
    half.back()->send("GET /");
  }
  CHECK(served.status(served.get("/")) == kOk);
  CHECK(half.front()->receive().empty());
  served.server->publish("rows", "{}");
  CHECK(stream.receive("data: {}\n\n").ends_with("event: rows\ndata: {}\n\n"));
}

TEST_CASE("what was published last is sent before the server ends") {
  Served served;
  Client client(served.server->url());
  client.send(served.get("/events")).receive("retry: 1000\n\n");
  served.server->publish("end", "");
  served.server.reset();
  CHECK(client.receive().ends_with("event: end\ndata: \n\n"));
}

TEST_CASE("a port that is taken is an error that says what would do") {
  const Served served;
  const auto port = static_cast<std::uint16_t>(std::stoi(served.host.substr(served.host.find(':') + 1)));
  const auto second = open_scope_server({port, "", ""});
  REQUIRE_FALSE(second);
  CHECK(second.error() == "port " + std::to_string(port) +
                              " of this machine: Address already in use; leave --scope-port out for one that is free");
}
