#pragma once
/// `evenstep catalogue`: the cells of all scenarios with a [case], such as those of scenarios/stiff and scenarios/extreme,
/// in shards (parts.h). An item is a cell; a scenario without a [case] is one item, the whole run. Each item depends on
/// nothing but the scenario and the program. From the cells of all shards, each case is judged as `evenstep run` judges it.

#include <functional>
#include <string>
#include <vector>

#include "evenstep/campaigns/parts.h"
#include "evenstep/format/reader.h"

namespace evenstep {

struct CatalogueOptions : PartOptions {
  std::vector<std::string> files;
  std::vector<std::string> set;
  Registry registry;
  bool long_ones = false;  ///< also scenarios with the tag "long"
};

/// One scenario of a complete catalogue. For a whole run only verdict, trace and failure are known.
struct CatalogueEntry {
  const Scenario* scenario = nullptr;
  RunOutcome outcome;
};

struct CatalogueOutcome : PartOutcome {
  std::int64_t left_out = 0;  ///< scenarios with the tag "long"
};

/// If the shard is the whole catalogue, or the whole is already complete, calls `judged` for each scenario in the order of
/// the files, and `exit` is the worst of their exit codes.
CatalogueOutcome run_catalogue(const CatalogueOptions& options, const std::function<void(CatalogueEntry&)>& judged);

}  // namespace evenstep
