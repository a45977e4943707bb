#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <tuple>

#include "evenstep/campaigns/sweep.h"
#include "sweep_file.h"
#include "sweep_lines.h"

namespace evenstep {
namespace {

/// A line and where it came from.
struct Line {
  std::string text;
  SweepPoint point;
  std::size_t part = 0, number = 0;
};

class Merge {
 public:
  explicit Merge(const std::vector<std::string>& parts) : parts_(parts) {}

  void read(std::vector<Diagnostic>& errors) {
    for (std::size_t part = 0; part < parts_.size(); ++part) read_part(part, errors);
  }
  /// Adds errors for points that are missing before the end.
  void check_gaps(std::vector<Diagnostic>& errors) const;
  /// The header and the lines as a single process writes them.
  std::vector<std::string> lines() const;
  SweepRecord record() const;

 private:
  void read_part(std::size_t part, std::vector<Diagnostic>& errors);
  bool belongs(const std::string& header, const std::string& part, std::vector<Diagnostic>& errors);
  /// One past the last point that counts, which is that of the K-th failure, or the last of all.
  std::int64_t end() const;

  const std::vector<std::string>& parts_;
  std::string header_line_;  // of the whole sweep
  SweepHeader header_;
  std::map<std::int64_t, Line> lines_;
};

bool Merge::belongs(const std::string& line, const std::string& part, std::vector<Diagnostic>& errors) {
  const SweepHeader header = internal::read_header_line(line).header;
  if (header_line_.empty()) header_ = header;
  // Paths may differ between machines. The same ones are kept, whatever the order of the parts.
  if (std::tie(header.file, header.set) < std::tie(header_.file, header_.set)) {
    header_.file = header.file;
    header_.set = header.set;
  }
  header_line_ = internal::header_line(header_, {});
  if (internal::same_sweep(header, header_)) return true;
  const std::string what = header.scenario != header_.scenario ? "another scenario (or other --set)"
                           : header.build != header_.build     ? "another build of evenstep"
                                                               : "another sweep";
  errors.push_back({part, 1, 1, fmt::format("is of {} than {}", what, parts_.front())});
  return false;
}

void Merge::read_part(std::size_t part, std::vector<Diagnostic>& errors) {
  const std::string& path = parts_[part];
  std::vector<std::string> lines;
  std::size_t number = 0;
  try {
    lines = internal::read_lines(path, true);
    std::error_code ignored;
    std::uintmax_t whole = 0;
    for (const std::string& line : lines) whole += line.size() + 1;
    if (lines.empty() || whole != std::filesystem::file_size(path, ignored)) {
      errors.push_back({path, std::ssize(lines) + 1, 1,
                        "the line has no end: the file was cut off, or its sweep has not ended; "
                        "`evenstep sweep --resume` ends it"});
      return;
    }
    number = 1;
    if (!belongs(lines.front(), path, errors)) return;
    for (number = 2; number <= lines.size(); ++number) {
      Line line{lines[number - 1], internal::read_point_line(header_, lines[number - 1]), part, number};
      const auto [there, added] = lines_.try_emplace(line.point.index, line);
      if (added) continue;
      errors.push_back({path, static_cast<std::int64_t>(number), 1,
                        fmt::format("point {} is in {}:{} already; merge each part once", line.point.index,
                                    parts_[there->second.part], there->second.number)});
      return;
    }
  } catch (const std::runtime_error& error) {
    const std::string message = number == 0 ? error.what() : fmt::format("the line {}", error.what());
    errors.push_back({path, static_cast<std::int64_t>(number), 1, message});
  }
}

std::int64_t Merge::end() const {
  std::int64_t failures = 0;
  for (const auto& [index, line] : lines_) {
    failures += internal::failed(line.point) ? 1 : 0;
    if (header_.stop_after && failures >= *header_.stop_after) return index + 1;
  }
  return header_.points();
}

void Merge::check_gaps(std::vector<Diagnostic>& errors) const {
  constexpr std::size_t kMostNamed = 10;
  std::vector<std::string> gaps;
  std::int64_t missing = 0, due = 0;
  const auto reach = [&](std::int64_t index) {  // the next point that is there
    if (index > due) gaps.push_back(index == due + 1 ? fmt::format("{}", due) : fmt::format("{}-{}", due, index - 1));
    missing += index - due;
    due = index + 1;
  };
  const std::int64_t last = end();
  for (const auto& [index, line] : lines_) {
    if (index < last) reach(index);
  }
  reach(last);
  if (missing == 0) return;
  const std::string more = gaps.size() > kMostNamed ? ", ..." : "";
  gaps.resize(std::min(gaps.size(), kMostNamed));
  errors.push_back({parts_.front(), 0, 0,
                    fmt::format("this and the other parts lack {} of {} points: {}{}; is a shard missing?", missing, last,
                                fmt::join(gaps, ", "), more)});
}

std::vector<std::string> Merge::lines() const {
  std::vector<std::string> out{header_line_};
  const auto last = lines_.lower_bound(end());
  for (auto line = lines_.begin(); line != last; ++line) out.push_back(line->second.text);
  return out;
}

SweepRecord Merge::record() const {
  SweepRecord record{header_, {}};
  const auto last = lines_.lower_bound(end());
  for (auto line = lines_.begin(); line != last; ++line) record.points.push_back(line->second.point);
  return record;
}

}  // namespace

SweepOutcome merge_sweep(const std::vector<std::string>& parts, const std::string& out) {
  SweepOutcome outcome;
  outcome.file = out;
  Merge merge(parts);
  merge.read(outcome.errors);
  if (outcome.errors.empty()) merge.check_gaps(outcome.errors);
  if (!outcome.errors.empty()) {
    outcome.exit = ExitCode::usage;
    return outcome;
  }
  try {
    internal::SweepFile file(out, false);
    for (const std::string& line : merge.lines()) file.append(line);
    file.finish();
  } catch (const std::exception& error) {
    outcome.failure = error.what();
    outcome.exit = ExitCode::run_failed;
    return outcome;
  }
  outcome.record = merge.record();
  outcome.summary = summarize(outcome.record);
  outcome.exit = internal::exit_of(outcome.summary);
  return outcome;
}

}  // namespace evenstep
