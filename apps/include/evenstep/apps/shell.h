#pragma once
/// Commands as text that a POSIX shell takes: for people to paste.

#include <string>
#include <vector>

#include "evenstep/reports/sweep_record.h"

namespace evenstep {

/// `word` as one word of a shell: quoted where it has to be.
std::string shell_word(const std::string& word);
/// The command that runs one point of a sweep again. `file`: the scenario as the caller reaches it; `set`: the --set arguments of
/// the sweep.
std::string point_command(const SweepHeader& header, const SweepPoint& point, const std::string& file,
                          const std::vector<std::string>& set = {});

}  // namespace evenstep
