#pragma once
/// A line of a part: one JSON object, whose last member is its checksum, "check": XXH64 of the object without it. It guards
/// against accidental damage, not against attacks, so 64 bits are enough.

#include <stdexcept>
#include <string>
#include <vector>

#include "evenstep/campaigns/parts.h"
#include "evenstep/reports/json.h"

namespace evenstep::internal {

[[noreturn]] inline void refuse_line(const std::string& why) { throw std::runtime_error(why); }
inline constexpr const char* kNotOurs = "is not a line that evenstep writes";

/// The line, which is a JSON object, with its checksum added.
std::string with_checksum(std::string line);
/// The line as it was before its checksum. Throws std::runtime_error if it has none, or another one.
std::string without_checksum(const std::string& line);

/// What `read` makes of a line; the errors of the JSON library become std::runtime_error.
template <class Read>
auto read_json_line(const std::string& line, Read read) {
  try {
    return read(Json::parse(without_checksum(line)));
  } catch (const nlohmann::json::exception&) {
    refuse_line(kNotOurs);
  } catch (const std::logic_error&) {  // of a number
    refuse_line(kNotOurs);
  }
}

/// The "shard" of a first line; that of the whole has none.
Shard read_shard(const Json& header);

/// What all first lines have, and what a merge compares, so that it need not read ten million seeds for each of ten thousand
/// parts.
struct PartHeader {
  std::string kind;
  Shard shard;
  std::string file;
  std::vector<std::string> set;
  std::string scenario, build;
  std::string common;  ///< the text that all parts share: all but shard and what only their results depend on (CampaignId)
  std::string whole;   ///< the line of the whole campaign, as this part would write it
};
PartHeader read_part_header(const std::string& line);
PartSubject read_part_subject(const std::string& line);

/// Whether two first lines are equal, except for the shard and what only the results depend on (the digest of the scenario
/// says whether names of files mean the same).
bool same_campaign(const std::string& a, const std::string& b);

}  // namespace evenstep::internal
