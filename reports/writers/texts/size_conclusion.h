#pragma once
/// The last parts of size_text.

#include <string>

#include "evenstep/reports/size_record.h"

namespace evenstep::internal {

constexpr double kSmooth =
    0.15;  // slots: a map whose velocity jumps by less is smooth; phase_locked accelerates by 0.07 at most

inline double ms(Duration duration) { return static_cast<double>(duration.ns) * 1e-6; }

/// The kinds of hitches, and what latency would do without each.
/// Why a recording is not one process, as far as it can tell.
std::string not_one_process(const SizeTrust& trust);
std::string hitches_text(const SizeRecord& record);
/// What the latency and the drawings would be with other pauses; empty if not requested.
std::string what_if_text(const SizeRecord& record);
/// What latency the same segments need in the worst order found; empty if not requested.
std::string worst_order_text(const SizeRecord& record);
/// Which map to use with which latency, why it needs that, and the scenario's tables for it.
std::string conclusion_text(const SizeRecord& record);
/// Whether what a program has is enough; empty if nobody asked.
std::string fit_text(const SizeRecord& record);

}  // namespace evenstep::internal
