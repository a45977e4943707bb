#pragma once
/// The page of a live run (`evenstep run --scope`), which shows what its server sends during the run
/// (reports/pages/web/scope.js says what).

#include <string>
#include <vector>

#include "evenstep/pages/page.h"

namespace evenstep {

struct ScopeText {
  std::string scenario, strategy;
  std::vector<std::string> devices;
  /// What a reader should know about direct's force; empty: it is shown for every device.
  std::string shadow_note;
  std::string program;  ///< what does not change, as JSON: "devices" with "name" and "limit_N", "strategy", "length_s"
};
Page scope_page(const ScopeText& text);

}  // namespace evenstep
