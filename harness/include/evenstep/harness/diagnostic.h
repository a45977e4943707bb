#pragma once
/// An error a user can cause: a place and a remedy, gcc style.

#include <cstdint>
#include <string>
#include <vector>

namespace evenstep {

struct Diagnostic {
  std::string file;
  std::int64_t line = 0, column = 0;    ///< 0: the whole file
  std::string message;                  ///< "unknown key 'vsi' in [timing]; did you mean 'visualization'?"
};

/// "scenarios/x.toml:12:1: error: unknown key …"
std::string text(const Diagnostic& diagnostic);

}  // namespace evenstep
