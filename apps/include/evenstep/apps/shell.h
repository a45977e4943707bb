#pragma once
/// Commands as text for a POSIX shell, for people to paste.

#include <string>
#include <string_view>
#include <vector>

#include "evenstep/reports/sweep_record.h"

namespace evenstep {

/// `word` as a single word for the shell, quoted if necessary.
std::string shell_word(const std::string& word);
/// The same for the name of a file, so that it is not taken for an option.
std::string shell_file(const std::string& file);
/// How this program was started, for the shell: `called_as` (from run.sh, which starts it) or else its own name, argv[0].
std::string program_words(const char* called_as, const char* own_name);
/// A message in which `evenstep list` and the like are written as they can be typed: with the program as it was started.
std::string with_program(std::string_view message, const std::string& program);
/// The command that runs one point of a sweep again. `file` is the path of the scenario from the working directory.
std::string point_command(const std::string& program, const SweepHeader& header, const SweepPoint& point,
                          const std::string& file);

}  // namespace evenstep
