// Unreal's CSV profiler: a row is a picture, with the times that it took in ms. There are no instants: a picture begins
// where the one before it ended, and the GPU's work on it is taken to begin with it. Columns may turn up during the
// recording; the complete header is then repeated behind the rows.
#include <fmt/format.h>

#include "column_names.h"
#include "decimal_time.h"
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

constexpr std::size_t kMostKept = std::size_t{256} << 20;  // bytes of rows

struct FrameRow {
  std::string text;
  std::int64_t line = 0;
};

/// The rows, and the last header of the file in `header`.
std::vector<FrameRow> rows_of(ProfileInput& input, ProfileBuilder& builder, std::vector<std::string>& header) {
  Lines lines(input.bytes);
  std::vector<FrameRow> rows;
  std::vector<std::string> cells;
  std::string_view line;
  std::size_t kept = 0;
  while (lines.next(line)) {
    if (line.empty() || line.starts_with("[")) continue;  // the footer: [HasHeaderRowAtEnd],1,…
    split_quoted(line, ',', cells);
    if (index_of(cells, "FrameTime")) {
      header = cells;
      continue;
    }
    kept += line.size() + sizeof(FrameRow);
    if (kept > kMostKept) {
      builder.fail(fmt::format("more than {} bytes of rows", kMostKept));
      break;
    }
    rows.push_back({std::string(line), lines.number()});
  }
  if (!lines.error().empty()) builder.fail(lines.error());
  return rows;
}

}  // namespace

bool is_unreal_csv(const ProfileInput& input) { return are_picture_lengths(input.head.cells); }

void read_unreal_csv(ProfileInput& input, const ProfileOptions&, ProfileBuilder& builder) {
  builder.profile().format = "Unreal CSV";
  builder.profile().time_base = "ms; pictures follow each other without a gap, and the GPU begins with each";
  builder.profile().only_visualizations = true;
  std::vector<std::string> header, cells;
  const std::vector<FrameRow> rows = rows_of(input, builder, header);
  if (builder.failed()) return;
  const std::optional<std::size_t> frame = index_of(header, "FrameTime");
  std::optional<std::size_t> gpu = index_of(header, "GPUTime");
  if (!gpu) gpu = index_of(header, "GPU/Total");
  if (!frame || !gpu)
    return builder.fail("has no column 'GPUTime' or 'GPU/Total' beside 'FrameTime': start it with -gpucsvstats");
  const std::uint32_t name = builder.name("GPU", "frame"), source = builder.track("");
  std::int64_t begin_ns = 0;
  for (const FrameRow& row : rows) {
    split_quoted(row.text, ',', cells);
    const auto time = [&](std::size_t column) {
      return column < cells.size() ? decimal_time_ns(cells[column], 1'000'000) : std::nullopt;
    };
    const std::optional<std::int64_t> length = time(*frame), drawn = time(*gpu);
    const std::string here = fmt::format("line {}", row.line);
    if (!length || *length < 0 || *length > kFurthestTime_ns - begin_ns) {
      builder.leave_out("rows without FrameTime", here);
      continue;
    }
    if (!drawn || *drawn <= 0 || *drawn > kFurthestTime_ns - begin_ns)
      builder.leave_out("pictures without times of the GPU", here);
    else
      builder.add(name, source, begin_ns, begin_ns + *drawn);
    begin_ns += *length;
    if (builder.failed()) return;
  }
}

}  // namespace evenstep::internal
