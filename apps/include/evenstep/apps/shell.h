#pragma once
/// Commands as text for a POSIX shell, for people to paste.

#include <string>
#include <vector>

#include "evenstep/reports/sweep_record.h"

namespace evenstep {

/// `word` as a single word for the shell, quoted if necessary.
std::string shell_word(const std::string& word);
/// The command that runs one point of a sweep again. `file` is the path of the scenario from here, `set` are the --set
/// arguments of the sweep.
std::string point_command(const SweepHeader& header, const SweepPoint& point, const std::string& file,
                          const std::vector<std::string>& set = {});

}  // namespace evenstep
