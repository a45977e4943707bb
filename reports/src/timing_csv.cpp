#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "evenstep/reports/writers.h"

namespace evenstep {
namespace {

struct Piece {
  const char* kind;
  std::int64_t index;
  RealTime begin, end;
};

/// The pieces of a segment in order of time, followed by the idle rest before the next segment, if there is any.
std::vector<Piece> pieces_of(const StrategyRecord& strategy, const SegmentRow& segment, std::size_t first,
                             std::size_t last) {
  std::vector<Piece> pieces;
  if (segment.visualization)
    pieces.push_back({"visualization", 0, (*segment.visualization)[0], (*segment.visualization)[1]});
  for (std::size_t n = first; n < last; ++n) {
    pieces.push_back({"step", static_cast<std::int64_t>(n - first), strategy.steps[n].begin, strategy.steps[n].end});
  }
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.begin < b.begin; });
  RealTime busy_until = segment.begin;
  for (const Piece& piece : pieces) busy_until = std::max(busy_until, piece.end);
  if (busy_until < segment.end) pieces.push_back({"idle", 0, busy_until, segment.end});
  return pieces;
}

}  // namespace

std::string timing_csv(const StrategyRecord& strategy) {
  std::string csv = "segment,kind,index,begin_ns,end_ns\n";
  std::size_t first = 0;
  for (const SegmentRow& segment : strategy.segments) {
    std::size_t last = first;
    while (last < strategy.steps.size() && strategy.steps[last].segment == segment.index) ++last;
    for (const Piece& piece : pieces_of(strategy, segment, first, last)) {
      fmt::format_to(std::back_inserter(csv), "{},{},{},{},{}\n", segment.index, piece.kind, piece.index, piece.begin.ns,
                     piece.end.ns);
    }
    first = last;
  }
  return csv;
}

}  // namespace evenstep
