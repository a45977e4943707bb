#pragma once
/// The readers, one for each format, behind one interface.

#include <span>
#include <string>
#include <string_view>

#include "bytes.h"
#include "csv_cells.h"
#include "profile_builder.h"

namespace evenstep::internal {

/// Where a profile is: a stream that has not been read yet, and, for what needs random access, the file or all its bytes.
struct ProfileInput {
  std::string path;         ///< of a file
  std::string_view memory;  ///< in place of a file, where `path` is empty
  Bytes& bytes;             ///< unpacked
  bool packed = false;      ///< whether they had to be unpacked
};

struct ProfileFormat {
  const char* word;                              ///< for --format: "nsight-sqlite"
  bool (*detect)(std::string_view first_bytes);  ///< of the unpacked file, up to 64 KiB
  void (*read)(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
};

/// In the order in which they are tried.
std::span<const ProfileFormat> formats();

// Each is in a source of its own.
bool is_sqlite(std::string_view first_bytes);
void read_nsight_sqlite(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_chrome_json(std::string_view first_bytes);
void read_chrome_json(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_presentmon(std::string_view first_bytes);
void read_presentmon(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_frame_csv(std::string_view first_bytes);
void read_frame_csv(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);
bool is_interval_csv(std::string_view first_bytes);
void read_interval_csv(ProfileInput& input, const ProfileOptions& options, ProfileBuilder& builder);

/// The header of a CSV, found in its first bytes as CsvTable finds it; empty if there is none.
std::vector<std::string> csv_header(std::string_view first_bytes);

}  // namespace evenstep::internal
