// A capture of CapFrameX: JSON with runs, and in each CaptureData the columns of PresentMon, an array of numbers each. They
// are read as the rows of PresentMon's CSV. Public source: CXWorld/CapFrameX,
// CapFrameX.Data.Session.Classes.SessionCaptureData.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "profile_formats.h"

namespace evenstep::internal {
namespace {

using nlohmann::json;

constexpr std::size_t kMostCaptureBytes = std::size_t{64} << 20;  // it is kept whole: hours of pictures
constexpr const char* kColumns[] = {"TimeInSeconds", "MsBetweenPresents", "MsUntilRenderComplete"};

/// The rows as a CSV; empty if the columns are not of one length.
std::string rows_of(const json& columns) {
  const auto column = [&](const char* name) -> const json* {
    const auto found = columns.find(name);
    return found != columns.end() && found->is_array() && !found->empty() ? &*found : nullptr;
  };
  std::vector<const json*> known;
  std::string text;
  for (const char* const name : kColumns) {
    if (column(name) == nullptr) continue;
    known.push_back(column(name));
    text += fmt::format("{}{}", text.empty() ? "" : ",", name);
  }
  for (const json* one : known) {
    if (one->size() != known.front()->size()) return "";
  }
  text += "\n";
  for (std::size_t row = 0; !known.empty() && row < known.front()->size(); ++row) {
    for (const json* one : known)
      text += (one == known.front() ? "" : ",") + ((*one)[row].is_number() ? (*one)[row].dump() : "NA");
    text += "\n";
  }
  return text;
}

}  // namespace

bool is_capframex_json(const ProfileInput& input) {
  return is_chrome_json(input) && input.first.find("\"CaptureData\"") != std::string_view::npos;
}

void read_capframex_json(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder) {
  std::string text;
  for (std::string_view piece = input.bytes.next(); !piece.empty(); piece = input.bytes.next()) {
    text += piece;
    if (text.size() > kMostCaptureBytes)
      return builder.fail(fmt::format("is a capture of more than {} bytes", kMostCaptureBytes));
  }
  const json capture = json::parse(text, nullptr, false);
  const json runs = capture.is_object() ? capture.value("Runs", json::array()) : json::array();
  if (capture.is_discarded()) return builder.fail("is a capture of CapFrameX, but no whole JSON; is it cut off?");
  if (!runs.is_array() || runs.empty() || !runs[0].is_object() || !runs[0].contains("CaptureData"))
    return builder.fail("is a capture of CapFrameX without a run");
  const std::string rows = rows_of(runs[0]["CaptureData"]);
  if (rows.empty()) return builder.fail("is a capture of CapFrameX whose columns are not of one length");
  const std::unique_ptr<Bytes> bytes = bytes_of_memory(rows);
  const std::string_view first = std::string_view(rows).substr(0, input.first.size());
  ProfileInput as_csv{input.path, rows, *bytes, first, find_csv_head(first, {}), false};
  read_pictures_csv(as_csv, options, builder);
  builder.profile().format = "CapFrameX capture";
  if (runs.size() > 1)
    builder.leave_out("further runs of the capture, each with a time of its own", "", false, std::ssize(runs) - 1);
}

}  // namespace evenstep::internal
