#include "profile_formats.h"

#include <fmt/format.h>

#include <utility>

#include "evenstep/text/suggest.h"

namespace evenstep {
namespace internal {
namespace {

constexpr ProfileFormat kFormats[] = {
    {"nsight-sqlite", is_sqlite, read_nsight_sqlite}, {"chrome-json", is_chrome_json, read_chrome_json},
    {"presentmon", is_presentmon, read_presentmon},   {"frame-csv", is_frame_csv, read_frame_csv},
    {"csv", is_interval_csv, read_interval_csv},
};

/// Gives back what was read ahead before it reads on.
class Rewound : public Bytes {
 public:
  Rewound(std::string ahead, std::unique_ptr<Bytes> rest) : ahead_(std::move(ahead)), rest_(std::move(rest)) {
    error_ = rest_->error();
  }
  std::string_view next() override {
    if (!std::exchange(given_, true) && !ahead_.empty()) return ahead_;
    const std::string_view piece = rest_->next();
    error_ = rest_->error();
    return piece;
  }

 private:
  std::string ahead_;
  std::unique_ptr<Bytes> rest_;
  bool given_ = false;
};

/// The bytes unpacked, and a copy of the first of them.
struct Opened {
  std::unique_ptr<Bytes> bytes;
  std::string first;
  bool packed = false;
};

Opened open(std::unique_ptr<Bytes> bytes) {
  std::string first(bytes->next());
  const bool packed = is_gzip(first);
  auto whole = std::make_unique<Rewound>(first, std::move(bytes));
  if (!packed) return {std::move(whole), first};
  std::unique_ptr<Bytes> plain = unpacked(std::move(whole));
  first = plain->next();
  return {std::make_unique<Rewound>(first, std::move(plain)), first, true};
}

std::string words(std::span<const ProfileFormat> all) {
  std::string text;
  for (const ProfileFormat& one : all) text += fmt::format("{}{}", text.empty() ? "" : ", ", one.word);
  return text;
}

const ProfileFormat* format_for(const ProfileOptions& options, std::string_view first, ProfileBuilder& builder) {
  if (!options.format.empty()) {
    for (const ProfileFormat& one : kFormats) {
      if (options.format == one.word) return &one;
    }
    std::vector<std::string_view> known;
    for (const ProfileFormat& one : kFormats) known.emplace_back(one.word);
    builder.fail(fmt::format("'{}' is no format{}", options.format, suggestion(options.format, known)));
    return nullptr;
  }
  if (!options.columns.begin.empty()) return &kFormats[std::size(kFormats) - 1];
  for (const ProfileFormat& one : kFormats) {
    if (one.detect(first)) return &one;
  }
  const std::vector<std::string> header = csv_header(first);
  if (header.empty()) {
    builder.fail(fmt::format("is no recording that can be read; the formats are {}", words(kFormats)));
  } else {
    std::string columns;
    for (const std::string& column : header) columns += fmt::format("{}'{}'", columns.empty() ? "" : ", ", column);
    builder.fail(
        fmt::format("is a CSV whose columns are not known; say which are which: --begin COLUMN, --end or --duration "
                    "COLUMN, --name COLUMN, --unit ms. It has {}",
                    columns.substr(0, 2000)),
        1, 1);
  }
  return nullptr;
}

ProfileResult read(const std::string& name, const std::string& path, std::string_view memory, Opened opened,
                   const ProfileOptions& options) {
  ProfileBuilder builder(name);
  const auto check = [&] {
    if (!opened.bytes->error().empty() && !builder.failed()) builder.fail(opened.bytes->error());
  };
  check();
  const ProfileFormat* const format = builder.failed() ? nullptr : format_for(options, opened.first, builder);
  if (format != nullptr) {
    ProfileInput input{path, memory, *opened.bytes, opened.packed};
    format->read(input, options, builder);
    check();
  }
  return builder.finish();
}

}  // namespace

std::span<const ProfileFormat> formats() { return kFormats; }

bool is_sqlite(std::string_view first_bytes) { return first_bytes.starts_with("SQLite format 3"); }

std::vector<std::string> csv_header(std::string_view first_bytes) {
  const std::unique_ptr<Bytes> bytes = bytes_of_memory(first_bytes);
  return CsvTable(*bytes).header();
}

}  // namespace internal

ProfileResult read_profile(const std::string& path, const ProfileOptions& options) {
  return internal::read(path, path, {}, internal::open(internal::bytes_of_file(path)), options);
}
ProfileResult parse_profile(std::string_view bytes, const std::string& name, const ProfileOptions& options) {
  return internal::read(name, "", bytes, internal::open(internal::bytes_of_memory(bytes)), options);
}
std::vector<std::string> profile_formats() {
  std::vector<std::string> all;
  for (const internal::ProfileFormat& one : internal::formats()) all.emplace_back(one.word);
  return all;
}

}  // namespace evenstep
