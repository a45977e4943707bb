#include "skipping_main.h"

#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdio>

int main(int argc, char** argv) {
  Catch::Session session;
  if (const int refused = session.applyCommandLine(argc, argv)) return refused;
  const bool lists =
      session.configData().listTests || session.configData().listTestNamesOnly || session.configData().listReporters;
  if (const std::string why = why_all_are_skipped(); !lists && !why.empty()) {
    std::printf("skipped: %s\n", why.c_str());
    return 0;
  }
  return session.run();
}
