#pragma once
/// The main function of test programs that need something from the machine which may be missing.

#include <string>

/// Why no test of the program can run here; empty if they can. Each such program defines this function.
std::string why_all_are_skipped();
