#include "profile_formats.h"

#include <fmt/format.h>

#include <utility>

#include "column_names.h"
#include "evenstep/text/suggest.h"

namespace evenstep {
namespace internal {
namespace {

constexpr ProfileFormat kFormats[] = {
    {"sqlite", is_sqlite, read_sqlite},
    {"capframex", is_capframex_json, read_capframex_json},
    {"chrome-json", is_chrome_json, read_chrome_json},
    {"presentmon", is_pictures_csv, read_pictures_csv},
    {"frame-csv", is_unreal_csv, read_unreal_csv},
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
  std::unique_ptr<Bytes> plain = std::make_unique<Rewound>(first, std::move(bytes));
  const auto unpack = [&](std::unique_ptr<Bytes> inner) {
    first = inner->next();
    plain = std::make_unique<Rewound>(first, std::move(inner));
  };
  if (packed) unpack(unpacked(std::move(plain)));
  if (is_utf16(first)) unpack(utf8_of_utf16(std::move(plain)));
  return {std::move(plain), std::move(first), packed};
}

std::string words(std::span<const ProfileFormat> all) {
  std::string text;
  for (const ProfileFormat& one : all) text += fmt::format("{}{}", text.empty() ? "" : ", ", one.word);
  return text;
}

/// Perfetto's own format is a message of packets, field 1 with a length, one behind the other.
bool is_perfetto_protobuf(std::string_view first) {
  std::size_t at = 0;
  for (int packet = 0; packet < 2; ++packet) {
    if (at >= first.size() || first[at++] != '\x0a') return false;
    std::size_t length = 0;
    for (int shift = 0; shift < 28 && at < first.size(); shift += 7) {
      const auto byte = static_cast<unsigned char>(first[at++]);
      length |= static_cast<std::size_t>(byte & 0x7F) << shift;
      if (byte < 0x80) break;
    }
    at += length;
  }
  return true;
}

/// What a file is that is no recording that can be read, and what would be one.
std::string what_else(std::string_view first) {
  if (is_perfetto_protobuf(first))
    return "is a trace of Perfetto (protobuf); make JSON of it, which is read: traceconv json FILE trace.json";
  if (first.starts_with("fps=") || first.starts_with("focus="))
    return "has the mean rates of gamescope (--stats-path), not the times of pictures; MangoHud logs these (log_interval=0)";
  return fmt::format("is no recording that can be read; the formats are {}", words(kFormats));
}

/// Why a CSV is none that is known, and what would help.
void refuse_csv(const ProfileOptions& options, const CsvHead& head, ProfileBuilder& builder) {
  std::string columns;
  for (const std::string& column : head.cells) columns += fmt::format("{}'{}'", columns.empty() ? "" : ", ", column);
  const std::string_view separator = head.separator == ',' ? "commas" : head.separator == ';' ? "semicolons" : "tabs";
  const std::string taken =
      fmt::format("line {} was taken for the header, split at {}, because {}", head.line, separator, head.why);
  if (const std::string_view why = why_refused(head.cells); !why.empty())
    return builder.fail(fmt::format("{} ({})", why, taken), head.line, 1);
  builder.fail(
      fmt::format("is a CSV whose columns are not known; say which are which: --begin COLUMN, --end or --duration COLUMN, "
                  "--name COLUMN, --unit ms{}. It has {} ({})",
                  options.header > 0 ? "" : "; or which line is the header: --header LINE", columns.substr(0, 2000), taken),
      head.line, 1);
}

const ProfileFormat* format_for(const ProfileOptions& options, const ProfileInput& input, ProfileBuilder& builder) {
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
    if (one.detect(input)) return &one;
  }
  if (options.header > 0 && input.head.line == 0)
    builder.fail(fmt::format("--header {}: there is no such line in its first 64 KiB", options.header));
  else if (input.head.line == 0)
    builder.fail(what_else(input.first));
  else
    refuse_csv(options, input.head, builder);
  return nullptr;
}

ProfileResult read(const std::string& name, const std::string& path, std::string_view memory, Opened opened,
                   const ProfileOptions& options) {
  ProfileBuilder builder(name);
  const auto check = [&] {
    if (!opened.bytes->error().empty() && !builder.failed()) builder.fail(opened.bytes->error());
  };
  check();
  ProfileInput input{path, memory, *opened.bytes, opened.first, {}, opened.packed};
  if (!is_sqlite(input) && !is_chrome_json(input)) input.head = find_csv_head(opened.first, options);
  const ProfileFormat* const format = builder.failed() ? nullptr : format_for(options, input, builder);
  if (format != nullptr) {
    format->read(input, options, builder);
    check();
  }
  return builder.finish();
}

}  // namespace

std::span<const ProfileFormat> formats() { return kFormats; }

bool is_sqlite(const ProfileInput& input) { return input.first.starts_with("SQLite format 3"); }

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
