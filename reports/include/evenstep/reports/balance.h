#pragma once
/// Conservation laws of a run: whatever went into its lanes came out of them or is counted as missed, dropped or overtaken.
/// Each side of a law was counted in a different place (the device lane, the rings, the recorder, the scheduler, the
/// driver), so a tick, sample, step or force that gets lost without being counted breaks one of them. They hold on any
/// machine, however late it is, and on every clock:
///
///   - Ticks of the grid up to the last that ran = ran + skipped. On the virtual clock all of the run's ticks ran.
///   - Ticks that ran = their forces on time + underrun + overrun + before the first force.
///   - Samples in the ring, or repeated = ticks that ran; for a driver that counts, ticks that ran <= reports + stale.
///   - Steps ended <= begun <= ended + 1, and begun <= due.
///   - Events 'tick' = ticks that ran; events 'step' = steps ended; steps begun <= events 'launch' <= begun + 1.
///   - Late reads, waits and late forces of all steps = rows of underruns.csv.
///   - Forces in the ring = steps that ended = sent + overtaken + dropped + pending.
///
/// Nothing here is about how late or how many: that is what expectations are for.

#include <string>
#include <vector>

#include "evenstep/reports/run_record.h"

namespace evenstep {

/// The laws that the run breaks, each as a line "left, phase_locked: 700 ticks ran, 699 samples are in the ring"; empty if
/// all add up. Records without a flow, which no lane made, are not checked. A run that breaks one is a defect of evenstep
/// (or of a driver of the program's own).
std::vector<std::string> imbalances(const RunRecord& run);

}  // namespace evenstep
