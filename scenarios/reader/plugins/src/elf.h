#pragma once
/// Whether a file can be a shared object of this machine, before the dynamic linker is asked: its words about a text file
/// ("invalid ELF header") help nobody.

#include <string>

namespace evenstep::internal {

/// What is wrong with the file at this path; empty if it looks like a shared object for this processor.
std::string objection_to_library(const std::string& path);

}  // namespace evenstep::internal
