#pragma once
/// The parts of a study, a sizing or the catalogue: items that are JSON objects, whose meaning only their own command knows.
/// A merge needs no more than their numbers.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "evenstep/format/reader.h"
#include "format.h"
#include "json.h"

namespace evenstep::internal {

/// What is done, and of which scenario.
struct CampaignId {
  std::string kind;  ///< "study", "size", "catalogue"
  std::string name, file;
  std::vector<std::string> set;
  std::string scenario;  ///< digest
  /// Members of the first line that decide nothing about an item, but that its command needs for the results (PartSubject).
  Json own = Json::object();
};

class JsonParts : public PartFormat {
 public:
  using Take = std::function<void(const Json& item)>;
  /// `more`: members of the first line, which all parts must share.
  JsonParts(const CampaignId& id, std::int64_t items, const Json& more, Take take);
  /// As a first line says it. Throws std::runtime_error.
  explicit JsonParts(const std::string& header_line);

  std::int64_t items() const override { return items_; }
  std::string header_line(Shard shard) const override;
  std::unique_ptr<PartItem> read(const std::string& line) const override;
  void take(const PartItem& item) override;

 private:
  Json header_;  // without a shard
  std::int64_t items_ = 0;
  Take take_;
};

/// The line of an item. Its members come after its index; "failed": true makes it count as one that failed.
std::string item_line(std::int64_t index, const Json& members);

/// A double as text that reads back to the same bits, also where JSON has no number for it: "nan", "inf", "-inf".
Json exact(double value);
double read_exact(const Json& json);

/// The digest of a scenario: of its whole table, in which the files that it names are represented by their contents, not by
/// their paths. Errors: the file cannot be read.
std::string digest_of_scenario(Value document);
std::string scenario_digest(const std::string& path, const ReadOptions& options, std::vector<Diagnostic>& errors);
/// Version and digest of the running program.
const std::string& build_id();

}  // namespace evenstep::internal
