#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <queue>
#include <set>
#include <stdexcept>
#include <tuple>

#include "evenstep/campaigns/sweep.h"
#include "part_lines.h"
#include "sweep_file.h"
#include "sweep_lines.h"

namespace evenstep {
namespace {

constexpr std::size_t kMostNamed = 10;
/// What all parts together may have in memory, and the least and the most that one reads at once.
constexpr std::size_t kMemory = std::size_t{64} << 20, kLeastPiece = std::size_t{4} << 10, kMostPiece = std::size_t{1} << 20;

/// The first of many, as text: "3, 17, ..."
class Named {
 public:
  void add(const std::string& one) {
    if (count_ < kMostNamed) text_ += (count_ == 0 ? "" : ", ") + one;
    if (count_ == kMostNamed) text_ += ", ...";
    ++count_;
  }
  const std::string& text() const { return text_; }
  std::size_t count() const { return count_; }

 private:
  std::string text_;
  std::size_t count_ = 0;
};

/// Points that no part has.
class Gaps {
 public:
  /// The next point that is there.
  void reach(std::int64_t index) {
    if (index > due_) {
      if (missing_ == 0) first_ = due_;
      missing_ += index - due_;
      spans_.add(index == due_ + 1 ? fmt::format("{}", due_) : fmt::format("{}-{}", due_, index - 1));
    }
    due_ = index + 1;
  }
  std::int64_t missing() const { return missing_; }
  std::int64_t first() const { return first_; }
  const std::string& text() const { return spans_.text(); }

 private:
  std::int64_t due_ = 0, missing_ = 0, first_ = 0;
  Named spans_;
};

struct MergePart {
  internal::PartLines lines;
  SweepShard shard;
  SweepPoint point;  ///< of the line that was read last
};

/// Reads parts side by side. Errors are collected, each with its place; a part with an error is not read on.
class Merge {
 public:
  Merge(const std::vector<std::string>& parts, std::vector<Diagnostic>& errors);

  /// The header of the whole sweep, if there was no error.
  const SweepHeader& header() const { return header_; }
  /// Hands over the points of the whole sweep and their lines, by rising index, until there is an error; reads on then, for
  /// further errors.
  void read(const std::function<void(const SweepPoint&, const std::string& line)>& take);

 private:
  /// Calls `step` for a part; an exception becomes an error at its line, and false.
  bool reading(MergePart& part, const std::function<bool()>& step);
  void read_header(MergePart& part);
  bool next_point(MergePart& part);
  /// Which shards are not there, or which part lacks points of its own.
  std::string who_lacks(const Gaps& gaps) const;
  void error_at(const MergePart& part, const std::string& message) {
    errors_.push_back({part.lines.path(), part.lines.number(), 1, message});
  }

  std::vector<MergePart> parts_;
  std::vector<Diagnostic>& errors_;
  SweepHeader header_;
  std::optional<internal::PartHeader> first_;  // of the parts whose header could be read
  std::string first_path_;
};

Merge::Merge(const std::vector<std::string>& parts, std::vector<Diagnostic>& errors) : errors_(errors) {
  const std::size_t piece = std::clamp(kMemory / std::max<std::size_t>(parts.size(), 1), kLeastPiece, kMostPiece);
  for (const std::string& part : parts) parts_.push_back({internal::PartLines(part, piece), {}, {}});
  for (MergePart& part : parts_) {
    reading(part, [&] {
      part.lines.next();
      read_header(part);
      return true;
    });
  }
}

bool Merge::reading(MergePart& part, const std::function<bool()>& step) {
  try {
    return step();
  } catch (const std::runtime_error& error) {
    error_at(part, fmt::format("the line {}", error.what()));
    return false;
  }
}

void Merge::read_header(MergePart& part) {
  const internal::PartHeader there = internal::read_part_header(part.lines.line());
  part.shard = there.shard;
  if (!first_) {
    header_ = internal::read_header_line(part.lines.line()).header;
    first_ = there;
    first_path_ = part.lines.path();
  }
  // Paths may differ between machines. The same ones are kept, whatever the order of the parts.
  if (std::tie(there.file, there.set) < std::tie(header_.file, header_.set)) {
    header_.file = there.file;
    header_.set = there.set;
  }
  if (there.common == first_->common) return;
  const std::string what = there.scenario != first_->scenario ? "another scenario (or other --set)"
                           : there.build != first_->build     ? "another build of evenstep"
                                                              : "another sweep";
  error_at(part, fmt::format("is of {} than {}", what, first_path_));
}

bool Merge::next_point(MergePart& part) {
  return reading(part, [&] {
    if (!part.lines.next()) return false;
    const std::int64_t before = part.lines.number() > 2 ? part.point.index : -1;
    part.point = internal::read_point_line(header_, part.lines.line());
    if (part.point.index <= before)
      throw std::runtime_error(fmt::format("is of point {}, after point {}", part.point.index, before));
    return true;
  });
}

void Merge::read(const std::function<void(const SweepPoint&, const std::string& line)>& take) {
  const auto later = [&](std::size_t a, std::size_t b) {
    return std::tie(parts_[a].point.index, a) > std::tie(parts_[b].point.index, b);
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> next(later);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (next_point(parts_[i])) next.push(i);
  }
  Gaps gaps;
  std::int64_t failures = 0, end = header_.points();  // one past the last point that counts: the K-th failure, or the last
  std::int64_t last = -1, number_of_last = 0;
  std::size_t part_of_last = 0;
  while (!next.empty()) {
    const std::size_t i = next.top();
    MergePart& part = parts_[i];
    next.pop();
    if (part.point.index == last) {
      error_at(part, fmt::format("point {} is in {}:{} already; merge each part once", last,
                                 parts_[part_of_last].lines.path(), number_of_last));
      continue;
    }
    last = part.point.index;
    part_of_last = i;
    number_of_last = part.lines.number();
    if (last < end) {
      gaps.reach(last);
      if (errors_.empty() && gaps.missing() == 0) take(part.point, part.lines.line());
      failures += internal::failed(part.point) ? 1 : 0;
      if (header_.stop_after && failures >= *header_.stop_after) end = last + 1;
    }
    if (next_point(part)) next.push(i);
  }
  gaps.reach(end);
  if (!errors_.empty() || gaps.missing() == 0) return;
  errors_.push_back({first_path_, 0, 0,
                     fmt::format("this and the other parts lack {} of {} points: {}; {}", gaps.missing(), end, gaps.text(),
                                 who_lacks(gaps))});
}

std::string Merge::who_lacks(const Gaps& gaps) const {
  const int of = parts_.front().shard.of;
  std::set<int> there;
  for (const MergePart& part : parts_) {
    if (part.shard.of != of) return "is a shard missing?";
    there.insert(part.shard.index);
  }
  Named missing;
  for (int shard = 1; shard <= of; ++shard) {
    if (there.count(shard) == 0) missing.add(fmt::format("{}", shard));
  }
  if (missing.count() > 0)
    return fmt::format("shard{} {} of {} {} missing", missing.count() == 1 ? "" : "s", missing.text(), of,
                       missing.count() == 1 ? "is" : "are");
  const int lacking = static_cast<int>(gaps.first() % of) + 1;
  const auto part = std::find_if(parts_.begin(), parts_.end(), [&](const MergePart& p) { return p.shard.index == lacking; });
  return fmt::format("point {} belongs into {}", gaps.first(), part->lines.path());
}

}  // namespace

SweepOutcome merge_sweep(const std::vector<std::string>& parts, const std::string& out) {
  SweepOutcome outcome;
  outcome.file = out;
  Merge merge(parts, outcome.errors);
  try {
    if (outcome.errors.empty()) {
      outcome.header = merge.header();
      internal::MergedFile file(out);
      file.append(internal::header_line(outcome.header, {}));
      SweepSummarizer summarizer(outcome.header);
      merge.read([&](const SweepPoint& point, const std::string& line) {
        file.append(line);
        summarizer.add(point);
      });
      if (outcome.errors.empty()) file.finish();
      outcome.summary = summarizer.summary();
    }
  } catch (const std::exception& error) {
    outcome.failure = error.what();
    outcome.exit = ExitCode::run_failed;
    return outcome;
  }
  outcome.exit = outcome.errors.empty() ? internal::exit_of(outcome.summary) : ExitCode::usage;
  return outcome;
}

}  // namespace evenstep
