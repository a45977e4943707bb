#pragma once
/// The main of test programs that need something of the machine which may not be there.

#include <string>

/// Why no test of the program can run here; empty if they can. Each such program defines it.
std::string why_all_are_skipped();
