#pragma once
/// The server behind `evenstep run --scope`: one page, and a stream of events for it (server-sent events, HTML Living
/// Standard 9.2), for browsers of this machine.
///
/// It listens on 127.0.0.1 alone. A request is granted only if it has the token of the page's address, a Host that names
/// this server (so no name that somebody else points here) and, if it has an Origin, this server's own; no other origin is
/// allowed to read. A request may be 8 KiB long and take 5 s, and less where more than 32 readers want to be served: then
/// the oldest makes room. A stream whose reader takes nothing for 10 s ends. At most kMostStreams are open at a time: a
/// further one gets 503. One thread of ordinary priority does all the work; publish() waits for no reader.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "evenstep/time/result.h"

namespace evenstep::app {

struct ScopeServerOptions {
  std::uint16_t port = 0;  ///< 0: a free one
  std::string page;        ///< its HTML
  std::string policy;      ///< its content security policy
  double request_s = 5;    ///< to send a request, and to read an answer that is no stream
};

struct ScopeCounts {
  std::uint64_t streams = 0;  ///< open now
  std::uint64_t opened = 0;   ///< streams so far
  std::uint64_t refused = 0;  ///< requests that were not answered with 200
  std::uint64_t dropped = 0;  ///< events that a stream's reader was too slow for, summed over streams
};

class ScopeServer {
 public:
  static constexpr std::size_t kMostStreams = 4;
  static constexpr std::size_t kMostWaiting = 16;  ///< events of a stream whose reader is slow; further ones are dropped

  virtual ~ScopeServer() = default;  ///< gives readers half a second for what they have not read yet
  /// "http://127.0.0.1:37123/?token=..."
  virtual const std::string& url() const = 0;
  /// Sends the event to each stream; `data` is one line. Callable from one thread.
  virtual void publish(const std::string& name, const std::string& data) = 0;
  virtual ScopeCounts counts() const = 0;  ///< callable from any thread
};

/// Whether this build has a scope server (EVENSTEP_SCOPE).
bool built_with_scope();
/// What to do instead where it has none.
inline constexpr std::string_view kInsteadOfScope = "leave --scope out: a line a second says the same";
/// The error says why it cannot be opened, and what would help.
Result<std::unique_ptr<ScopeServer>, std::string> open_scope_server(const ScopeServerOptions& options);

}  // namespace evenstep::app
