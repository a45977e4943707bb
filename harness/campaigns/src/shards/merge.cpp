#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <queue>
#include <set>
#include <stdexcept>
#include <tuple>

#include "file.h"
#include "format.h"
#include "json.h"
#include "json_parts.h"
#include "lines.h"
#include "src/sweep/lines.h"

namespace evenstep {
namespace {

constexpr std::size_t kMostNamed = 10;
/// What all parts together may keep in memory, and the least and the most that one part reads at once.
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

/// Items that no part has.
class Gaps {
 public:
  /// The next item that is there.
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
  Shard shard;
  std::unique_ptr<internal::PartItem> item;  ///< of the line that was read last
};

/// Reads parts side by side. Errors are collected, each with its place; a part with an error is not read on.
class Merge {
 public:
  Merge(const std::vector<std::string>& parts, std::vector<Diagnostic>& errors);

  /// The first line of the whole, if there was no error.
  const std::string& header_line() const { return header_.whole; }
  /// Hands over the items of the whole and their lines, by rising index, until there is an error; reads on then, for further
  /// errors. Returns how many there are.
  std::int64_t read(const std::function<void(const internal::PartItem&, const std::string& line)>& take);

 private:
  /// Calls `step` for a part; an exception becomes an error at its line, and false.
  bool reading(MergePart& part, const std::function<bool()>& step);
  void read_header(MergePart& part);
  bool next_item(MergePart& part);
  /// Which shards are not there, or which part lacks items of its own.
  std::string who_lacks(const Gaps& gaps) const;
  void error_at(const MergePart& part, const std::string& message) {
    errors_.push_back({part.lines.path(), part.lines.number(), 1, message});
  }

  std::vector<MergePart> parts_;
  std::vector<Diagnostic>& errors_;
  std::unique_ptr<internal::PartFormat> format_;  // by the first header that could be read
  internal::PartHeader header_, first_;
  std::string first_path_;
};

Merge::Merge(const std::vector<std::string>& parts, std::vector<Diagnostic>& errors) : errors_(errors) {
  const std::size_t piece = std::clamp(kMemory / std::max<std::size_t>(parts.size(), 1), kLeastPiece, kMostPiece);
  for (const std::string& part : parts) parts_.push_back({internal::PartLines(part, piece), {}, nullptr});
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
  if (!format_) {
    format_ = internal::format_of(part.lines.line());
    header_ = first_ = there;
    first_path_ = part.lines.path();
  }
  if (there.common == first_.common) {
    // Paths may differ between machines. The merge keeps the same ones whatever the order of the parts.
    if (std::tie(there.file, there.set, there.whole) < std::tie(header_.file, header_.set, header_.whole)) header_ = there;
    return;
  }
  if (there.kind != first_.kind)
    return error_at(part, fmt::format("is of a {}, but {} of a {}", there.kind, first_path_, first_.kind));
  const std::string what = there.scenario != first_.scenario ? "another scenario (or other --set)"
                           : there.build != first_.build     ? "another build of evenstep"
                                                             : fmt::format("another {}", first_.kind);
  error_at(part, fmt::format("is of {} than {}", what, first_path_));
}

bool Merge::next_item(MergePart& part) {
  return reading(part, [&] {
    if (!part.lines.next()) return false;
    const std::int64_t before = part.item ? part.item->index : -1;
    part.item = format_->read(part.lines.line());
    if (part.item->index <= before)
      throw std::runtime_error(fmt::format("is of point {}, after point {}", part.item->index, before));
    return true;
  });
}

std::int64_t Merge::read(const std::function<void(const internal::PartItem&, const std::string& line)>& take) {
  const auto later = [&](std::size_t a, std::size_t b) {
    return std::tie(parts_[a].item->index, a) > std::tie(parts_[b].item->index, b);
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> next(later);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (next_item(parts_[i])) next.push(i);
  }
  Gaps gaps;
  std::int64_t failures = 0, end = format_->items();  // one past the last item that counts: the K-th failure, or the last
  std::int64_t last = -1, number_of_last = 0;
  std::size_t part_of_last = 0;
  while (!next.empty()) {
    const std::size_t i = next.top();
    MergePart& part = parts_[i];
    next.pop();
    if (part.item->index == last) {
      error_at(part, fmt::format("point {} is in {}:{} already; merge each part once", last,
                                 parts_[part_of_last].lines.path(), number_of_last));
      continue;
    }
    last = part.item->index;
    part_of_last = i;
    number_of_last = part.lines.number();
    if (last < end) {
      gaps.reach(last);
      if (errors_.empty() && gaps.missing() == 0) take(*part.item, part.lines.line());
      failures += part.item->failed ? 1 : 0;
      if (format_->stop_after() && failures >= *format_->stop_after()) end = last + 1;
    }
    if (next_item(part)) next.push(i);
  }
  gaps.reach(end);
  if (!errors_.empty() || gaps.missing() == 0) return end;
  errors_.push_back({first_path_, 0, 0,
                     fmt::format("this and the other parts lack {} of {} points: {}; {}", gaps.missing(), end, gaps.text(),
                                 who_lacks(gaps))});
  return end;
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

namespace {

/// Why this cannot be the merged file, which replaces what is there under its name; or nothing. With `parts/*.jsonl` as
/// parts and one of these as the merged file, the merge would destroy a part; and a device or a pipe would become a file.
std::string merge_objection(const std::vector<std::string>& parts, const std::string& out) {
  std::error_code none;
  const std::filesystem::file_status there = std::filesystem::status(out, none);
  if (!std::filesystem::exists(there)) return {};
  if (!std::filesystem::is_regular_file(there)) return "is no file that could be replaced; give another name with --out";
  const auto same = [&](const std::string& part) { return std::filesystem::equivalent(part, out, none); };
  return std::any_of(parts.begin(), parts.end(), same) ? "is one of the parts; give another name with --out" : "";
}

}  // namespace

PartOutcome internal::merge_into(const std::vector<std::string>& parts, const std::string& out,
                                 std::unique_ptr<PartFormat>& format) {
  PartOutcome outcome;
  outcome.file = out;
  if (std::string objection = merge_objection(parts, out); !objection.empty()) {
    outcome.errors.push_back({out, 0, 0, std::move(objection)});
    outcome.exit = ExitCode::usage;
    return outcome;
  }
  Merge merge(parts, outcome.errors);
  try {
    if (outcome.errors.empty()) {
      MergedFile file(out);
      file.append(merge.header_line());
      format = format_of(merge.header_line());
      outcome.items = format->items();
      outcome.done = merge.read([&](const PartItem& item, const std::string& line) {
        file.append(line);
        format->take(item);
      });
      if (outcome.errors.empty()) file.finish();
    }
  } catch (const std::exception& error) {
    outcome.failure = error.what();
    outcome.exit = ExitCode::run_failed;
    return outcome;
  }
  if (!outcome.errors.empty()) outcome.exit = ExitCode::usage;
  return outcome;
}

std::string kind_of_part(const std::string& file) {
  internal::PartLines lines(file, kMostPiece);
  try {
    lines.next();
    return internal::read_part_header(lines.line()).kind;
  } catch (const std::runtime_error&) {
    return {};
  }
}

Result<PartSubject> subject_of_part(const std::string& file) {
  internal::PartLines lines(file, kMostPiece);
  try {
    lines.next();
    return internal::read_part_subject(lines.line());
  } catch (const std::runtime_error& error) {
    return Failure(fmt::format("{}:1: error: the line {}", file, error.what()));
  }
}

std::unique_ptr<internal::PartFormat> internal::format_of(const std::string& header_line) {
  if (read_part_header(header_line).kind == "sweep")
    return std::make_unique<SweepParts>(read_header_line(header_line).header);
  return std::make_unique<JsonParts>(header_line);
}

PartOutcome merge_parts(const std::vector<std::string>& parts, const std::string& out) {
  std::unique_ptr<internal::PartFormat> format;
  return internal::merge_into(parts, out, format);
}

}  // namespace evenstep
