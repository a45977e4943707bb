#include "mocked_hidraw.h"
#include "skipping_main.h"

std::string why_all_are_skipped() {
  if (MockedHidraw::possible()) return "";
  return "libumockdev-preload.so.0 is not preloaded (package umockdev); run it through ctest or umockdev-wrapper";
}
