#pragma once
/// A place in a file, and an error that a user can cause: the place and a message with a remedy, printed in gcc's format.

#include <cstdint>
#include <string>
#include <vector>

namespace evenstep {

/// Where something is written. Line and column count from 1; 0 means the whole file.
struct Place {
  std::string file;
  std::int64_t line = 0, column = 0;
  bool operator==(const Place&) const = default;
};

struct Diagnostic {
  std::string file;
  std::int64_t line = 0, column = 0;  ///< 0: the whole file
  std::string message;                ///< "unknown key 'vsi' in [timing]; did you mean 'visualization'?"
  bool operator==(const Diagnostic&) const = default;
};

/// "scenarios/x.toml:12:1: error: unknown key …"
std::string text(const Diagnostic& diagnostic);

}  // namespace evenstep
