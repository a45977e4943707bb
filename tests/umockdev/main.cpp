#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdio>

#include "mocked_hidraw.h"

int main(int argc, char** argv) {
  Catch::Session session;
  if (const int refused = session.applyCommandLine(argc, argv)) return refused;
  if (!session.configData().listTests && !session.configData().listTestNamesOnly && !MockedHidraw::possible()) {
    std::puts(
        "skipped: libumockdev-preload.so.0 is not preloaded (package umockdev); run it through ctest or umockdev-wrapper");
    return 0;
  }
  return session.run();
}
