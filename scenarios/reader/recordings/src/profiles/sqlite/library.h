#pragma once
/// A database that is only read, and not trusted. libsqlite3 is opened with the first one.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/time/result.h"
#include "src/profiles/profile_builder.h"

struct sqlite3;
struct sqlite3_stmt;

namespace evenstep::internal {

class Database {
 public:
  /// The file, or `memory` if `path` is empty (which must outlive this). The file is not locked, and nothing is written
  /// beside it.
  static Result<Database> open(const std::string& path, std::string_view memory);

  enum class Kind { table, view };
  /// The columns of a table, or of a view; empty if there is none of this name and kind.
  std::vector<std::string> columns(const std::string& name, Kind kind = Kind::table) const;

  /// The row that a query has come to.
  class Row {
   public:
    explicit Row(sqlite3_stmt* statement) : statement_(statement) {}
    bool is_null(int column) const;
    std::int64_t whole(int column) const;
    /// Holds till the next row.
    std::string_view text(int column) const;

   private:
    sqlite3_stmt* statement_;
  };
  /// Calls `row` for each row till it returns false. The error is SQLite's; empty if there is none.
  std::string query(const std::string& sql, const std::function<bool(const Row&)>& row) const;

 private:
  struct Close {
    void operator()(sqlite3* database) const;
  };
  explicit Database(sqlite3* database) : database_(database) {}
  std::unique_ptr<sqlite3, Close> database_;
};

/// False if it is no database of rocpd.
bool read_rocpd(const Database& database, ProfileBuilder& builder);

}  // namespace evenstep::internal
