#include "library.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <filesystem>

#include "evenstep/time/library_on_demand.h"

namespace evenstep::internal {
namespace {

// clang-format off
#define EVENSTEP_SQLITE_FUNCTIONS(X)                                                                               \
  X(sqlite3_open_v2) X(sqlite3_close_v2) X(sqlite3_prepare_v2) X(sqlite3_step) X(sqlite3_finalize)                 \
  X(sqlite3_column_int64) X(sqlite3_column_text) X(sqlite3_column_bytes) X(sqlite3_column_type) X(sqlite3_errmsg)  \
  X(sqlite3_limit) X(sqlite3_db_config) X(sqlite3_progress_handler) X(sqlite3_deserialize)
// clang-format on

struct Sqlite {
#define EVENSTEP_DECLARE(name) decltype(&::name) name = nullptr;
  EVENSTEP_SQLITE_FUNCTIONS(EVENSTEP_DECLARE)
#undef EVENSTEP_DECLARE
  std::string missing;
};

const Sqlite& sqlite() {
  static const Sqlite library = [] {
    Sqlite wanted;
#define EVENSTEP_BY_NAME(name) FunctionByName{#name, reinterpret_cast<void**>(&wanted.name)},
    wanted.missing = load_on_demand("libsqlite3.so.0", {EVENSTEP_SQLITE_FUNCTIONS(EVENSTEP_BY_NAME)}).value_or("");
#undef EVENSTEP_BY_NAME
    return wanted;
  }();
  return library;
}

/// immutable: no lock and no journal, so a folder that cannot be written will do.
std::string uri_of(const std::string& path) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' || c == '.' ||
                       c == '-' || c == '_';
    if (plain)
      uri += c;
    else
      uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri + "?immutable=1";
}

/// A stranger's file may make a query endless. This stops it after some minutes of work.
int stop_endless(void* rounds) { return ++*static_cast<std::int64_t*>(rounds) > 20'000 ? 1 : 0; }

constexpr int kLongestValue = 1 << 24;
constexpr int kRound = 1'000'000;  // operations of SQLite's machine

}  // namespace

void Database::Close::operator()(sqlite3* database) const { sqlite().sqlite3_close_v2(database); }

Result<Database> Database::open(const std::string& path, std::string_view memory) {
  const Sqlite& library = sqlite();
  if (!library.missing.empty())
    return Failure(fmt::format("SQLite cannot be loaded: {}; install libsqlite3-0", library.missing));
  sqlite3* opened = nullptr;
  const int status = library.sqlite3_open_v2(path.empty() ? ":memory:" : uri_of(path).c_str(), &opened,
                                             SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
  Database database(opened);
  if (status != SQLITE_OK) return Failure(std::string(opened == nullptr ? "out of memory" : library.sqlite3_errmsg(opened)));
  library.sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, kLongestValue);
  library.sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  library.sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  const auto readable = [&]() -> Result<Database> {
    const std::string error = database.query("SELECT count(*) FROM sqlite_master", [](const Row&) { return false; });
    if (!error.empty()) return Failure(error);
    return std::move(database);
  };
  if (!path.empty()) return readable();
  // Read only, so SQLite does not write there; its interface is older than const.
  auto* const bytes = reinterpret_cast<unsigned char*>(const_cast<char*>(memory.data()));
  const auto size = static_cast<sqlite3_int64>(memory.size());
  if (library.sqlite3_deserialize(opened, "main", bytes, size, size, SQLITE_DESERIALIZE_READONLY) != SQLITE_OK)
    return Failure(std::string(library.sqlite3_errmsg(opened)));
  return readable();
}

bool Database::Row::is_null(int column) const { return sqlite().sqlite3_column_type(statement_, column) == SQLITE_NULL; }
std::int64_t Database::Row::whole(int column) const { return sqlite().sqlite3_column_int64(statement_, column); }
std::string_view Database::Row::text(int column) const {
  const unsigned char* const text = sqlite().sqlite3_column_text(statement_, column);
  if (text == nullptr) return {};
  return {reinterpret_cast<const char*>(text), static_cast<std::size_t>(sqlite().sqlite3_column_bytes(statement_, column))};
}

std::string Database::query(const std::string& sql, const std::function<bool(const Row&)>& row) const {
  sqlite3_stmt* statement = nullptr;
  std::int64_t rounds = 0;
  sqlite().sqlite3_progress_handler(database_.get(), kRound, stop_endless, &rounds);
  int status = sqlite().sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &statement, nullptr);
  if (status == SQLITE_OK) {
    status = sqlite().sqlite3_step(statement);
    while (status == SQLITE_ROW && row(Row(statement))) status = sqlite().sqlite3_step(statement);
  }
  const bool fine = status == SQLITE_OK || status == SQLITE_DONE || status == SQLITE_ROW;
  std::string error = fine ? "" : sqlite().sqlite3_errmsg(database_.get());
  sqlite().sqlite3_finalize(statement);
  sqlite().sqlite3_progress_handler(database_.get(), 0, nullptr, nullptr);
  return error;
}

std::vector<std::string> Database::columns(const std::string& name, Kind kind) const {
  std::vector<std::string> names;
  bool is_there = false;
  // A table with pages of its own: a virtual one would run code.
  const std::string of_kind = kind == Kind::view ? "type = 'view'" : "type = 'table' AND rootpage > 0";
  const auto ignored = query("SELECT 1 FROM sqlite_master WHERE " + of_kind + " AND name = '" + name + "'",
                             [&](const Row&) { return is_there = true, false; });
  if (is_there) {
    const auto error = query("PRAGMA table_info('" + name + "')", [&](const Row& row) {
      names.emplace_back(row.text(1));
      return names.size() < 1000;
    });
    if (!error.empty()) names.clear();
  }
  return names;
}

}  // namespace evenstep::internal
