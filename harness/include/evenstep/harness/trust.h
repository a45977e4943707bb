#pragma once
/// What can be promised about a rate of underruns, from what the segments need of a map, in the order of time.
///
/// Neighbouring segments are alike, so n of them say less than n independent ones. Where a share of the segments is late,
/// the variance of their number is D times that of independent ones,
///   D = 1 + 2 * sum over lags k >= 1 of the autocorrelation of "late" at lag k,
/// with the sum ended as by Geyer (initial monotone sequence, Stat. Sci. 7, 1992). D is the largest for the upper tenth and
/// fiftieth of the leads and of the delays (at least 20 segments), and D segments count as one.
///
/// Lead and latency are chosen by the segments that judge them. They solve min L subject to c >= a_k, L - c >= b_k: a linear
/// program in two variables, from which the k worst constraints were taken out. For n independent segments the share of all
/// segments that the solution violates is above e with a probability of at most
///   (k + 1) P(Bin(n, e) <= k + 1)
/// in whatever way the k were chosen (Campi and Garatti, J. Optim. Theory Appl. 148, 2011, theorem 2.1, with two variables).
///
/// That is a promise about the process that was recorded. Whether it is one process is tested: blocks of at least 3 D
/// segments, D here that of their ranks, on either side of the likeliest change; the largest standardised difference between
/// the blocks before and after any place (CUSUM), of the mean ranks and of the largest ones, of leads and of delays, against
/// 999 permutations of the blocks. The level is 5 % for independent blocks: so often a recording that does not change is
/// taken for one that does (where neighbours are alike, up to three times as often: trust_test.cpp). With fewer than 10
/// blocks nothing can be tested, and nothing is promised.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "evenstep/harness/segment_needs.h"
#include "evenstep/reports/size_record.h"

namespace evenstep::internal {

/// D of any values in the order of time: by how much the variance of their mean exceeds that of independent ones. At least
/// 1; 1 if nothing varies.
double dispersion(std::span<const double> values);
/// The needs rounded up to a thousandth of the latency of all: for what is promised, so that a drift too small to matter is
/// neither a change nor makes neighbours alike.
std::vector<SegmentNeed> rounded_up(std::span<const SegmentNeed> needs);
/// D and the test for change, of needs rounded so.
SizeTrust trust_in(std::span<const SegmentNeed> needs);
/// D alone, of segments of one process.
double alike_segments(std::span<const SegmentNeed> needs);

/// The upper bound, at this confidence, on the share of segments with an underrun, at the least lead and latency at which
/// `underruns` of `segments` have one, if `alike` of them count as one. It is 1 if there are too few.
double chosen_rate_at_most(std::int64_t underruns, std::int64_t segments, double alike, double confidence);
/// The most underruns for which that bound is not above `rate`; -1: not even none.
std::int64_t most_chosen_underruns(double rate, double confidence, std::int64_t segments, double alike);
/// The least number of segments, all without an underrun, for which it is not above `rate`.
std::int64_t chosen_segments_needed(double rate, double confidence, double alike);

}  // namespace evenstep::internal
