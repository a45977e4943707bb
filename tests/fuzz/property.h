#pragma once
// Properties that must hold for every input. A violation ends the program like a crash, so that the fuzzer keeps the input.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "evenstep/text/diagnostic.h"

namespace evenstep::test {

inline void require(bool holds, const std::string& broken) {
  if (holds) return;
  std::fprintf(stderr, "property broken: %s\n", broken.c_str());
  std::abort();
}

/// An input must be read, or refused with at least one error, and each error must say what is wrong and where.
inline void require_read_or_refused(bool read, const std::vector<Diagnostic>& errors) {
  require(read == errors.empty(), "neither read nor refused");
  for (const Diagnostic& error : errors) {
    require(!error.message.empty(), "an error without words");
    require(error.line >= 1 && error.column >= 1, "an error without a place: " + text(error));
  }
}

}  // namespace evenstep::test
