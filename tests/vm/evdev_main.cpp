#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdio>

#include "uinput_device.h"

int main(int argc, char** argv) {
  Catch::Session session;
  if (const int refused = session.applyCommandLine(argc, argv)) return refused;
  const bool lists = session.configData().listTests || session.configData().listTestNamesOnly;
  if (const std::string refusal = UinputDevice::refusal(); !lists && !refusal.empty()) {
    std::printf("skipped: %s (the vm_ tests run the same on a kernel of their own)\n", refusal.c_str());
    return 0;
  }
  return session.run();
}
