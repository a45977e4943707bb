#include "skipping_main.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

#define CATCH_CONFIG_RUNNER
#include "catch.h"

int main(int argc, char** argv) {
  Catch::Session session;
  if (const int refused = session.applyCommandLine(argc, argv)) return refused;
  const bool lists =
      std::any_of(argv, argv + argc, [](std::string_view argument) { return argument.starts_with("--list-"); });
  if (const std::string why = why_all_are_skipped(); !lists && !why.empty()) {
    std::printf("skipped: %s\n", why.c_str());
    return 0;
  }
  return session.run();
}
