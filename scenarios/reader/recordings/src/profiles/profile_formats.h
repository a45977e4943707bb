#pragma once
/// The readers, one for each format, behind one interface.

#include <span>
#include <string>
#include <string_view>

#include "bytes.h"
#include "csv_cells.h"
#include "csv_head.h"
#include "profile_builder.h"

namespace evenstep::internal {

/// Where a profile is: a stream that has not been read yet, and, for what needs random access, the file or all its bytes.
struct ProfileInput {
  std::string path;         ///< of a file
  std::string_view memory;  ///< in place of a file, where `path` is empty
  Bytes& bytes;             ///< unpacked
  std::string_view first;   ///< of them, up to 64 KiB
  CsvHead head;             ///< if it is a CSV
  bool packed = false;      ///< whether they had to be unpacked
};

struct ProfileFormat {
  const char* word;  ///< for --format: "sqlite"
  bool (*detect)(const ProfileInput& input);
  void (*read)(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
};

/// In the order in which they are tried.
std::span<const ProfileFormat> formats();

// Each is in a source of its own.
bool is_sqlite(const ProfileInput& input);
void read_sqlite(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_capframex_json(const ProfileInput& input);
void read_capframex_json(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_chrome_json(const ProfileInput& input);
void read_chrome_json(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_pictures_csv(const ProfileInput& input);
void read_pictures_csv(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_unreal_csv(const ProfileInput& input);
void read_unreal_csv(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_interval_csv(const ProfileInput& input);
void read_interval_csv(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);

}  // namespace evenstep::internal
