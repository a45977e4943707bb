#pragma once
/// The files that are written into every page; pages/embed.cmake makes them a part of the program.

#include <string_view>

namespace evenstep::internal {

struct PageFile {
  std::string_view text;
  std::string_view sha256;  ///< in base64, as a content security policy names it
};
/// LICENSE is uPlot's.
extern const PageFile uPlot_iife_min_js, uPlot_min_css, LICENSE, report_css, page_js, report_js, scope_js;

}  // namespace evenstep::internal
