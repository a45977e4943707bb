#include "json.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>

namespace evenstep::internal {
namespace {

constexpr int kLineFormat = 1;
constexpr std::array<const char*, 4> kKinds{"sweep", "study", "size", "catalogue"};
/// Members of the first line in which parts may differ.
constexpr std::array<const char*, 6> kOwn{"file", "set", "files", "long", "rate", "confidence"};

/// The last member of a line, as it is written.
std::string checksum_member(std::string_view line) {
  return fmt::format(",\"check\":\"{:016x}\"}}", XXH64(line.data(), line.size(), 0));
}
constexpr std::size_t kChecksumMember = 28;

}  // namespace

std::string with_checksum(std::string line) {
  const std::string member = checksum_member(line);
  line.pop_back();
  return line + member;
}

std::string without_checksum(const std::string& line) {
  const std::size_t begin = line.size() - std::min(line.size(), kChecksumMember);
  const std::string rest = line.substr(0, begin) + "}";
  if (line.compare(begin, std::string::npos, checksum_member(rest)) == 0) return rest;
  refuse_line(line.find("\"check\":") == std::string::npos ? fmt::format("has no checksum: it {}", kNotOurs)
                                                           : "does not agree with its checksum: it is damaged");
}

Shard read_shard(const Json& header) {
  if (!header.contains("shard")) return {};
  const Shard shard{header.at("shard").at(0).get<int>(), header.at("shard").at(1).get<int>()};
  if (shard.of < 2 || shard.of > kMostShards || shard.index < 1 || shard.index > shard.of)
    refuse_line("is of no possible shard");
  return shard;
}

PartHeader read_part_header(const std::string& line) {
  return read_json_line(line, [](Json json) {
    if (json.at("format").get<int>() != kLineFormat) refuse_line("is of another format");
    PartHeader out;
    for (const char* kind : kKinds) {
      if (json.contains(kind)) out.kind = kind;
    }
    if (out.kind.empty()) refuse_line(kNotOurs);
    out.shard = read_shard(json);
    out.file = json.at("file").get<std::string>();
    out.scenario = json.at("scenario").get<std::string>();
    out.build = json.at("build").get<std::string>();
    if (json.contains("set")) out.set = json.at("set").get<std::vector<std::string>>();
    json.erase("shard");
    out.whole = with_checksum(json_text(json));
    for (const char* own : kOwn) json.erase(own);
    out.common = json_text(json);
    return out;
  });
}

PartSubject read_part_subject(const std::string& line) {
  const PartHeader header = read_part_header(line);
  return read_json_line(line, [&](const Json& json) {
    PartSubject subject;
    subject.kind = header.kind;
    subject.file = header.file;
    subject.set = header.set;
    if (header.kind == "catalogue") {
      subject.files = json.at("files").get<std::vector<std::string>>();
      subject.long_ones = json.at("long").get<bool>();
    }
    if (header.kind == "size") {
      subject.rate = json.at("rate").get<double>();
      subject.confidence = json.at("confidence").get<double>();
      subject.seeds = json.at("seeds").get<std::string>();
      subject.other_maps = json.at("other_maps").get<bool>();
    }
    return subject;
  });
}

bool same_campaign(const std::string& a, const std::string& b) {
  return read_part_header(a).common == read_part_header(b).common;
}

}  // namespace evenstep::internal
