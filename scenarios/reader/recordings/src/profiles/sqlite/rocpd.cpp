// rocpd, AMD's database of a trace: what rocprofv3 and rocprof-sys write unless told otherwise. Its views join its tables,
// whose names end in a number of the run and whose columns have changed (times of their own table since schema 3), into one
// row an interval; so the views are read. Times are ns. Public source: ROCm/rocprofiler-sdk,
// source/share/rocprofiler-sdk-rocpd.
#include <fmt/format.h>

#include <algorithm>

#include "library.h"
#include "src/profiles/decimal_time.h"
#include "src/profiles/profile_builder.h"

namespace evenstep::internal {
namespace {

/// A view of intervals with the columns name, start and end.
struct View {
  const char* name;
  const char* category;
  TrackOrder order;               ///< of the intervals of a queue or a thread
  std::vector<const char*> lane;  ///< columns with that queue or thread; the first that is there
};

// clang-format off: a row reads as a row
const std::vector<View>& views() {
  static const std::vector<View> all{
      {"kernels", "kernel", TrackOrder::follow, {"queue_id", "queue"}},
      {"memory_copies", "copy", TrackOrder::any, {"queue_id", "queue_name"}},
      {"regions", "range", TrackOrder::nest, {"tid"}},
  };
  return all;
}
// clang-format on

class RocpdReader {
 public:
  RocpdReader(const Database& database, ProfileBuilder& builder) : database_(database), builder_(builder) {}

  void read() {
    for (const View& view : views()) {
      columns_ = database_.columns(view.name, Database::Kind::view);
      if (!columns_.empty() && !builder_.failed()) read_view(view);
    }
    if (builder_.profile().intervals.empty() && !builder_.failed())
      builder_.fail("is a rocpd database without kernels and regions; was anything of the GPU recorded (--kernel-trace)?");
  }

 private:
  bool has(const std::string& column) const { return std::find(columns_.begin(), columns_.end(), column) != columns_.end(); }

  void read_view(const View& view) {
    if (!has("name") || !has("start") || !has("end"))
      return builder_.fail(fmt::format("{} has no columns name, start and end", view.name));
    // The text of a marker is in its extra data; its name is the function that set it.
    std::string sql = R"(SELECT start, "end", )";
    sql += has("extdata") ? "COALESCE(CASE WHEN json_valid(extdata) THEN json_extract(extdata, '$.message') END, name)"
                          : "name";
    int columns = 3;
    const auto ask = [&](std::vector<const char*> names) {
      const auto found = std::find_if(names.begin(), names.end(), [&](const char* name) { return has(name); });
      if (found == names.end()) return -1;
      sql += fmt::format(R"(, "{}")", *found);
      return columns++;
    };
    const int process = ask({"pid"}), agent = ask({"agent_abs_index", "agent_absolute_index"}), lane = ask(view.lane);
    sql += fmt::format(" FROM {}", view.name);
    const auto error = database_.query(sql, [&](const Database::Row& row) {
      const std::string name(row.text(2).substr(0, kLongestName));
      if (row.is_null(0) || row.is_null(1) || far(row.whole(0)) || far(row.whole(1))) {
        builder_.leave_out(fmt::format("rows of {} without an end", view.name), name);
      } else {
        std::string source = process < 0 ? "" : fmt::format("process {}", row.whole(process));
        if (agent >= 0 && !row.is_null(agent))
          source += fmt::format("{}agent {}", source.empty() ? "" : ", ", row.whole(agent));
        const std::string lane_text = lane < 0 ? "" : std::string(row.text(lane).substr(0, kLongestName));
        builder_.add(builder_.name(name, view.category),
                     builder_.track(source, lane_text, lane_text.empty() ? TrackOrder::any : view.order), row.whole(0),
                     row.whole(1));
      }
      return !builder_.failed();
    });
    if (!error.empty() && !builder_.failed()) builder_.fail(fmt::format("{}: {}", view.name, error));
  }

  static bool far(std::int64_t ns) { return ns > kFurthestTime_ns || ns < -kFurthestTime_ns; }

  const Database& database_;
  ProfileBuilder& builder_;
  std::vector<std::string> columns_;  ///< of the view being read
};

}  // namespace

bool read_rocpd(const Database& database, ProfileBuilder& builder) {
  if (database.columns("rocpd_metadata", Database::Kind::view).empty()) return false;
  builder.profile().format = "rocpd SQLite";
  RocpdReader(database, builder).read();
  return true;
}

}  // namespace evenstep::internal
