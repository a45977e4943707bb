#include "json_parts.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cmath>
#include <limits>

#include "evenstep/format/document.h"
#include "evenstep/format/load.h"
#include "evenstep/harness/version.h"
#include "evenstep/text/text_file.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kMostFileBytes = std::int64_t{1} << 31;

std::string digest(const std::string& bytes) { return fmt::format("{:016x}", XXH64(bytes.data(), bytes.size(), 0)); }

/// The digest of a file's contents. An unreadable file counts as empty; the error is reported when a point is read.
std::string digest_of_file(const std::string& path) { return digest(read_text_file(path, kMostFileBytes).value_or("")); }

struct JsonItem : PartItem {
  Json json;
};

}  // namespace

std::string digest_of_scenario(Value document) {
  if (const CommandFiles command = files_of_command(document); command.directory != nullptr) {
    std::string contents;
    for (const std::string& file : command.files) contents += digest_of_file(file);
    command.directory->text = contents;
  }
  for (Value* file : named_files(document)) file->text = digest_of_file(path_from(*file));
  return digest(print_toml(document));
}

std::string scenario_digest(const std::string& path, const ReadOptions& options, std::vector<Diagnostic>& errors) {
  Errors of_files;
  const Value document = load_with_overrides(path, options, of_files);
  if (of_files.any()) errors = of_files.sorted(path);
  return errors.empty() ? digest_of_scenario(document) : "";
}

const std::string& build_id() {
  static const std::string id = fmt::format("{}-{}", kVersion, digest_of_file("/proc/self/exe"));
  return id;
}

JsonParts::JsonParts(const CampaignId& id, std::int64_t items, const Json& more, Take take)
    : items_(items), take_(std::move(take)) {
  header_["format"] = 1;
  header_[id.kind] = id.name;
  header_["file"] = id.file;
  if (!id.set.empty()) header_["set"] = id.set;
  header_.update(id.own);
  header_["scenario"] = id.scenario;
  header_["build"] = build_id();
  header_["points"] = items;
  header_.update(more);
}

JsonParts::JsonParts(const std::string& header_line) {
  header_ = read_json_line(read_part_header(header_line).whole, [](Json json) { return json; });
  items_ = read_json_line(header_line, [](const Json& json) { return json.at("points").get<std::int64_t>(); });
  if (items_ < 1 || items_ > kMostSweepPoints) refuse_line("has no possible number of points");
}

std::string JsonParts::header_line(Shard shard) const {
  Json json = header_;
  if (shard.of > 1) json["shard"] = {shard.index, shard.of};
  return with_checksum(json_text(json));
}

std::unique_ptr<PartItem> JsonParts::read(const std::string& line) const {
  return read_json_line(line, [&](Json json) {
    auto item = std::make_unique<JsonItem>();
    item->index = json.at("index").get<std::int64_t>();
    if (item->index < 0 || item->index >= items_) refuse_line(fmt::format("has the number {} of no point", item->index));
    item->failed = json.contains("failed") && json.at("failed").get<bool>();
    if (with_checksum(json_text(json)) != line) refuse_line(kNotOurs);
    item->json = std::move(json);
    return std::unique_ptr<PartItem>(std::move(item));
  });
}

void JsonParts::take(const PartItem& item) {
  if (!take_) return;
  try {
    take_(static_cast<const JsonItem&>(item).json);
  } catch (const nlohmann::json::exception&) {
    refuse_line(kNotOurs);
  }
}

std::string item_line(std::int64_t index, const Json& members) {
  Json json = {{"index", index}};
  json.update(members);
  return with_checksum(json_text(json));
}

Json exact(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

double read_exact(const Json& json) {
  if (!json.is_string()) return json.get<double>();
  const std::string word = json.get<std::string>();
  if (word == "nan") return std::numeric_limits<double>::quiet_NaN();
  if (word != "inf" && word != "-inf") refuse_line(kNotOurs);
  return word == "inf" ? HUGE_VAL : -HUGE_VAL;
}

}  // namespace evenstep::internal
