#include "status.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "evenstep/reports/unicode.h"

namespace evenstep::app {
namespace {

constexpr std::array kStateTexts{"ARMED",
                                 "RAMPING",
                                 "WAITING",
                                 "CUT (motors off)",
                                 "CUT (hand not reported)",
                                 "CUT (no new force)",
                                 "CUT (hand too fast)"};

/// Three digits, but never an exponent.
std::string number(double value) {
  return std::abs(value) < 999.5 ? fmt::format("{:.3g}", value) : fmt::format("{:.0f}", value);
}
std::string in_ms(Duration time) { return number(static_cast<double>(time.ns) * 1e-6); }

/// Counts one column per code point. Wide and combining characters only make the line end earlier or later.
std::size_t columns_of(std::string_view text) {
  std::size_t count = 0;
  for (; !text.empty(); ++count) take_code_point(text);
  return count;
}

std::string visible(std::string_view name) {
  std::string out;
  while (!name.empty()) {
    const char32_t c = take_code_point(name);
    append_utf8(out, is_unseen(c) ? U'?' : c);
  }
  return out;
}

std::string first_columns(std::string_view text, std::size_t columns) {
  std::string out;
  for (; columns > 0 && !text.empty(); --columns) append_utf8(out, take_code_point(text));
  return out;
}

/// A part of the line in two lengths; an empty one is left out. The larger the rank, the sooner a part is left out.
struct Part {
  int rank;
  std::string whole, brief;
};

/// "ARMED", or of several devices "left ARMED, right CUT (hand too fast)".
std::string states(const WatchedRun& run, const LiveSnapshot& snapshot) {
  std::string text;
  for (std::size_t i = 0; i < run.devices.size(); ++i) {
    if (i > 0) text += ", ";
    if (run.devices.size() > 1) text += visible(run.devices[i].name) + ' ';
    text += state_text(run.devices[i], snapshot.devices[i]);
  }
  return text;
}

Part force_part(const WatchedRun& run, const LiveSnapshot& snapshot) {
  Part part{6, "force ", ""};
  for (std::size_t i = 0; i < run.devices.size(); ++i) {
    const std::string force = number(snapshot.devices[i].force_N);
    const char* const between = i > 0 ? ", " : "";
    part.whole += fmt::format("{}{} of {} N", between, force, number(run.devices[i].limit_N));
    part.brief += fmt::format("{}{} N", between, force);
  }
  part.whole += fmt::format(", {} clamped (run {})", snapshot.last.clamped, snapshot.whole.clamped);
  return part;
}

std::string per_second(std::int64_t count, Duration span) {
  return span.ns > 0 ? fmt::format("{:.0f}", static_cast<double>(count) / seconds(span)) : "0";
}

std::vector<Part> parts_of(const WatchedRun& run, const LiveSnapshot& now) {
  const LiveSpan &last = now.last, &whole = now.whole;
  const auto counted = [](std::int64_t in_last, std::int64_t in_run, const char* what) {
    return fmt::format("{} {} (run {})", in_last, what, in_run);
  };
  std::vector<Part> parts;
  parts.push_back({0, states(run, now), states(run, now)});
  const auto devices = static_cast<std::int64_t>(run.devices.size());
  const std::string ticks =
      per_second(last.counts.ticks, now.span * devices) + (devices > 1 ? " ticks/s and device" : " ticks/s");
  parts.push_back({7, fmt::format("{}, {} steps/s", ticks, per_second(last.counts.steps, now.span)), ticks});
  parts.push_back({2,
                   fmt::format("lateness p50 {}, p99 {}, max {} ms (run {})", in_ms(now.lateness_p50),
                               in_ms(now.lateness_p99), in_ms(last.lateness_max), in_ms(whole.lateness_max)),
                   fmt::format("late p99 {}, max {} ms", in_ms(now.lateness_p99), in_ms(last.lateness_max))});
  parts.push_back(
      {3, counted(last.counts.missed, whole.counts.missed, "ticks missed"), fmt::format("{} missed", last.counts.missed)});
  parts.push_back({4, counted(last.counts.underruns(), whole.counts.underruns(), "underruns"),
                   fmt::format("{} underruns", last.counts.underruns())});
  if (whole.least_margin)
    parts.push_back({5,
                     fmt::format("least margin {} (run {})", last.least_margin ? in_ms(*last.least_margin) + " ms" : "none",
                                 in_ms(*whole.least_margin)),
                     last.least_margin ? fmt::format("margin {} ms", in_ms(*last.least_margin)) : ""});
  parts.push_back(force_part(run, now));
  if (now.dropped > 0) parts.push_back({8, fmt::format("{} records not shown", now.dropped), ""});
  const std::string left = fmt::format("{:.0f} s left", std::ceil(seconds(now.left)));
  if (now.ended)
    parts.push_back({1, fmt::format("ended after {} s", number(seconds(now.now - RealTime{0}))), "ended"});
  else
    parts.push_back({1, left + ", Ctrl-C ends it", left + ", Ctrl-C"});
  return parts;
}

std::string joined(const std::vector<Part>& parts, bool brief, int most_rank) {
  std::string line;
  for (const Part& part : parts) {
    const std::string& text = brief ? part.brief : part.whole;
    if (part.rank > most_rank || text.empty()) continue;
    line += (line.empty() ? "" : " | ") + text;
  }
  return line;
}

}  // namespace

std::string state_text(const WatchedRun::Device& device, const LiveSnapshot::Device& seen) {
  if (!device.sends) return "READ ONLY";
  return seen.guard ? kStateTexts.at(static_cast<std::size_t>(*seen.guard)) : "WAITING";
}

bool any_cut(const WatchedRun& run, const LiveSnapshot& snapshot) {
  for (std::size_t i = 0; i < run.devices.size(); ++i) {
    const std::optional<GuardState> guard = snapshot.devices[i].guard;
    if (run.devices[i].sends && guard && *guard >= GuardState::cut_device) return true;
  }
  return false;
}

std::string status_line(const WatchedRun& run, const LiveSnapshot& snapshot, std::optional<std::size_t> columns) {
  const std::vector<Part> parts = parts_of(run, snapshot);
  std::string line = joined(parts, false, 8);
  if (!columns) return line;
  for (int most_rank = 8; most_rank >= 0 && columns_of(line) > *columns; --most_rank) line = joined(parts, true, most_rank);
  return first_columns(line, *columns);
}

std::string drawn(const Screen& screen, const WatchedRun& run, const LiveSnapshot& snapshot) {
  if (!screen.terminal) return status_line(run, snapshot) + '\n';
  const bool red = screen.colour && any_cut(run, snapshot);
  std::string line = "\r\033[K" + std::string(red ? "\033[31m" : "") + status_line(run, snapshot, screen.columns);
  if (red) line += "\033[0m";
  return snapshot.ended ? line + '\n' : line;
}

}  // namespace evenstep::app
