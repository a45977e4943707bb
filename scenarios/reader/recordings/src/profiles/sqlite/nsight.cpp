// What `nsys export --type sqlite` writes. A table is there only if something of its kind was recorded. Times are ns.
// Two generations: up to 2022.2 (schema 2.9) the schema is named in EXPORT_META_DATA, later (3.x) in META_DATA_EXPORT;
// columns that one of them lacks are not asked for.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "library.h"
#include "src/profiles/decimal_time.h"
#include "src/profiles/profile_formats.h"

namespace evenstep::internal {
namespace {

/// A table of intervals with the columns start and end.
struct Table {
  const char* name;
  const char* category;
  const char* label;               ///< the name of all its rows; nullptr: `names` has it
  std::vector<const char*> names;  ///< columns with the name: an id of a string, or a text; the first that is there
};

// clang-format off: a row reads as a row
constexpr const char* kCopyKinds[] = {"copy",
                                      "copy host to device",
                                      "copy device to host",
                                      "copy host to array",
                                      "copy array to host",
                                      "copy array to array",
                                      "copy array to device",
                                      "copy device to array",
                                      "copy device to device",
                                      "copy host to host",
                                      "copy peer to peer"};
const std::vector<Table>& tables() {
  static const std::vector<Table> all{
      {"CUPTI_ACTIVITY_KIND_KERNEL", "kernel", nullptr, {"shortName", "demangledName"}},
      {"CUPTI_ACTIVITY_KIND_MEMCPY", "copy", "copy", {"copyKind"}},
      {"CUPTI_ACTIVITY_KIND_MEMSET", "copy", "set memory", {}},
      {"VULKAN_WORKLOAD", "workload", "Vulkan workload", {"textId"}},
      {"DX12_WORKLOAD", "workload", "DX12 workload", {"textId", "nameId"}},
      {"OPENGL_WORKLOAD", "workload", "OpenGL workload", {"textId", "nameId"}},
      {"NVTX_EVENTS", "range", nullptr, {"text", "textId"}},
  };
  return all;
}
// clang-format on

class NsightReader {
 public:
  NsightReader(const Database& database, ProfileBuilder& builder) : database_(database), builder_(builder) {}

  void read() {
    read_strings();
    int found = 0;
    for (const Table& table : tables()) {
      columns_ = database_.columns(table.name);
      if (columns_.empty() || builder_.failed()) continue;
      ++found;
      read_table(table);
    }
    if (found == 0 && !builder_.failed())
      builder_.fail(
          "is a database without tables of Nsight Systems (CUPTI_ACTIVITY_KIND_KERNEL, NVTX_EVENTS, …) and views of rocpd; "
          "was anything of the GPU recorded?");
  }

  std::string schema() const {
    std::string version;
    for (const char* const table : {"META_DATA_EXPORT", "EXPORT_META_DATA"}) {
      if (database_.columns(table).empty()) continue;
      const auto error = database_.query(fmt::format("SELECT value FROM {} WHERE name = 'EXPORT_SCHEMA_VERSION'", table),
                                         [&](const Database::Row& row) {
                                           version = row.text(0).substr(0, 20);
                                           return false;
                                         });
      if (!error.empty()) return "";
    }
    return version;
  }

 private:
  bool has(const std::string& column) const { return std::find(columns_.begin(), columns_.end(), column) != columns_.end(); }

  void read_strings() {
    if (database_.columns("StringIds").empty()) return;
    std::size_t bytes = 0;
    const auto error = database_.query("SELECT id, value FROM StringIds", [&](const Database::Row& row) {
      const std::string_view text = row.text(1).substr(0, kLongestName);
      strings_.insert_or_assign(row.whole(0), std::string(text));
      bytes += text.size();
      return strings_.size() < kMostNames && bytes < kMostNameBytes;
    });
    if (!error.empty()) builder_.fail(fmt::format("StringIds: {}", error));
  }

  void read_table(const Table& table) {
    if (!has("start") || !has("end")) return builder_.fail(fmt::format("{} has no columns start and end", table.name));
    std::string sql = R"(SELECT start, "end")";
    int columns = 2;
    const auto ask = [&](const char* column) {
      if (!has(column)) return -1;
      sql += fmt::format(", {}", column);
      return columns++;
    };
    std::vector<int> names;
    for (const char* const name : table.names) names.push_back(ask(name));
    const int device = ask("deviceId"), pid = ask("globalPid"), tid = ask("globalTid");
    sql += fmt::format(" FROM {}", table.name);
    // 59: pushed and popped, 60: started and ended; the others are marks and names of things.
    if (std::string_view(table.category) == "range" && has("eventType")) sql += " WHERE eventType IN (59, 60)";
    const auto error = database_.query(sql, [&](const Database::Row& row) {
      const std::string name = name_of(table, row, names);
      if (row.is_null(0) || row.is_null(1) || row.whole(1) == 0 || far(row.whole(0)) || far(row.whole(1)))
        builder_.leave_out(fmt::format("rows of {} without an end", table.name), name);
      else
        builder_.add(builder_.name(name, table.category), source(row, device, pid >= 0 ? pid : tid), row.whole(0),
                     row.whole(1));
      return !builder_.failed();
    });
    if (!error.empty() && !builder_.failed()) builder_.fail(fmt::format("{}: {}", table.name, error));
  }

  static bool far(std::int64_t ns) { return ns > kFurthestTime_ns || ns < -kFurthestTime_ns; }

  std::string name_of(const Table& table, const Database::Row& row, const std::vector<int>& names) const {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] < 0 || row.is_null(names[i])) continue;
      const std::string_view column = table.names[i];
      if (column == "text") return std::string(row.text(names[i]).substr(0, kLongestName));
      const std::int64_t id = row.whole(names[i]);
      if (column == "copyKind") return kCopyKinds[id >= 0 && id < std::ssize(kCopyKinds) ? id : 0];
      const auto found = strings_.find(id);
      if (found != strings_.end()) return found->second;
    }
    return table.label == nullptr ? "without a name" : table.label;
  }

  std::uint32_t source(const Database::Row& row, int device, int process) const {
    std::string text;
    // A global id has the process in its bits 24 to 47.
    if (process >= 0 && !row.is_null(process)) text = fmt::format("process {}", (row.whole(process) >> 24) & 0xFFFFFF);
    if (device >= 0 && !row.is_null(device)) text += fmt::format("{}GPU {}", text.empty() ? "" : ", ", row.whole(device));
    return builder_.track(text);  // a stream may run several kernels of a graph at a time
  }

  const Database& database_;
  ProfileBuilder& builder_;
  std::map<std::int64_t, std::string> strings_;
  std::vector<std::string> columns_;  ///< of the table being read
};

}  // namespace

void read_sqlite(ProfileInput& input, const ProfileOptions&, ProfileBuilder& builder) {
  builder.profile().time_base = "ns, as its tables have them";
  if (input.packed) return builder.fail("is a gzipped database; unpack it first");
  const Result<Database> database = Database::open(input.path, input.memory);
  if (!database) return builder.fail(fmt::format("SQLite: {}", database.error()));
  if (read_rocpd(*database, builder)) return;
  builder.profile().format = "Nsight Systems SQLite";
  NsightReader reader(*database, builder);
  const std::string schema = reader.schema();
  if (!schema.empty()) builder.profile().format += fmt::format(", schema {}", schema);
  reader.read();
}

}  // namespace evenstep::internal
