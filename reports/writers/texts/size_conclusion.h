#pragma once
/// The answer of size_text, and its last parts.

#include <string>

#include "evenstep/reports/size_record.h"

namespace evenstep::internal {

constexpr double kSmooth =
    0.15;  // slots: a map whose velocity jumps by less is smooth; phase_locked accelerates by 0.07 at most

inline double ms(Duration duration) { return static_cast<double>(duration.ns) * 1e-6; }

/// Which map to use with which latency, lead and rings: what is asked for, so it is printed first.
std::string answer(const SizeRecord& record);
/// Why there is no latency for a span of time, and how much more of the recording would do.
std::string why_refused(const SizePer& per, const SizeTrust& trust);
/// The kinds of hitches, and what latency would do without each.
std::string hitches_text(const SizeRecord& record);
/// What the latency and the drawings would be with other pauses; empty if not requested.
std::string what_if_text(const SizeRecord& record);
/// What latency the same segments need in the worst order found; empty if not requested.
std::string worst_order_text(const SizeRecord& record);
/// Why the map to use needs its latency, and the scenario's tables for it.
std::string reasons_text(const SizeRecord& record);
/// Whether what a program has is enough; empty if nobody asked.
std::string fit_text(const SizeRecord& record);

}  // namespace evenstep::internal
