#pragma once
/// The server behind `evenstep run --scope`: one page, and a stream of events for it (server-sent events, HTML Living
/// Standard 9.2), for browsers of this machine.
///
/// It listens on 127.0.0.1 alone. An answer needs the token of the address that it was opened with, a Host that names it (so
/// no name that somebody else's server points here) and, if there is an Origin, its own; it gives no other origin leave to
/// read. A request may be 8 KiB long and take 5 s, a stream whose reader takes nothing for 10 s ends, and there are as many
/// as kMostStreams at a time: a further one gets 503. Everything that it does is done by one thread of its own, of ordinary
/// priority; publish() waits for no reader.

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

/// Whether this build has one (EVENSTEP_SCOPE).
bool built_with_scope();
/// What a call may do in its place.
inline constexpr std::string_view kInsteadOfScope = "leave --scope out: a line a second says the same";
/// The error says why not, and what would do.
Result<std::unique_ptr<ScopeServer>, std::string> open_scope_server(const ScopeServerOptions& options);

}  // namespace evenstep::app
