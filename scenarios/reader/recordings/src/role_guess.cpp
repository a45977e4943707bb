// What is in a recording, and a first guess at what each name in it stands for.
#include <algorithm>
#include <map>
#include <tuple>

#include "evenstep/recordings/roles.h"

namespace evenstep {
namespace {

Duration median(std::vector<Duration>& lengths) {
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

bool speaks_of(const std::string& text, std::initializer_list<const char*> words) {
  std::string lower;
  for (const char c : text) lower += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return lower.find(word) != std::string::npos; });
}

/// The expression that matches exactly this text.
std::string exactly(const std::string& text) {
  std::string expression = "^";
  for (const char c : text) {
    if (std::string_view("\\^$.[]|()*+?{}").find(c) != std::string_view::npos) expression += '\\';
    expression += c;
  }
  return expression + "$";
}

std::string any_of(const std::vector<std::string>& names) {
  std::string expression;
  for (const std::string& name : names) expression += (expression.empty() ? "" : "|") + exactly(name);
  return expression.size() <= 1000 ? expression : "";
}

}  // namespace

std::string summary_text(const std::string& name) {
  const std::size_t digits = name.find_last_not_of("0123456789") + 1;
  if (digits == 0 || digits == name.size() || name[digits - 1] != '#') return name;
  return name.substr(0, digits) + "N";
}

std::vector<NameSummary> summarize(const Profile& profile) {
  std::map<std::pair<std::string, std::string>, std::size_t> groups;
  std::vector<std::size_t> group_of_name(profile.names.size());
  std::vector<NameSummary> names;
  for (std::size_t i = 0; i < profile.names.size(); ++i) {
    const std::string text = summary_text(profile.names[i].text);
    const auto [group, is_new] = groups.try_emplace({text, profile.names[i].category}, names.size());
    if (is_new) names.push_back({text, profile.names[i].category, 0, {}, std::nullopt});
    group_of_name[i] = group->second;
  }
  std::vector<std::vector<std::size_t>> members(names.size());
  for (std::size_t i = 0; i < profile.intervals.size(); ++i) members[group_of_name[profile.intervals[i].name]].push_back(i);
  std::vector<Duration> lengths, periods;
  for (std::size_t g = 0; g < names.size(); ++g) {
    lengths.clear();
    periods.clear();
    for (std::size_t k = 0; k < members[g].size(); ++k) {
      const ProfileInterval& interval = profile.intervals[members[g][k]];
      lengths.push_back(interval.end - interval.begin);
      if (k > 0) periods.push_back(interval.begin - profile.intervals[members[g][k - 1]].begin);
    }
    names[g].count = static_cast<std::int64_t>(lengths.size());
    if (!lengths.empty()) names[g].median = median(lengths);
    if (!periods.empty()) names[g].period = median(periods);
  }
  std::erase_if(names, [](const NameSummary& one) { return one.count == 0; });
  std::sort(names.begin(), names.end(), [](const NameSummary& a, const NameSummary& b) {
    return a.count != b.count ? a.count > b.count : std::tie(a.text, a.category) < std::tie(b.text, b.category);
  });
  return names;
}

Roles guess_roles(const Profile& profile) {
  Roles roles;
  if (profile.only_visualizations) {
    roles.visualization = ".";
    return roles;
  }
  std::vector<NameSummary> kernels;
  std::vector<std::string> shown, steps;
  for (const NameSummary& name : summarize(profile)) {
    if (name.count > 1 && name.text.ends_with("#N") && roles.segment.empty()) {
      const std::string exact = exactly(name.text.substr(0, name.text.size() - 1));
      roles.segment = exact.substr(0, exact.size() - 1) + "[0-9]+$";
    } else if (name.category == "kernel") {
      kernels.push_back(name);
    } else if (name.category != "copy" && speaks_of(name.text, {"render", "draw", "visuali", "present"})) {
      shown.push_back(name.text);
    } else if (speaks_of(name.text, {"step", "solve", "integrate", "simulat", "physics"})) {
      steps.push_back(name.text);
    }
  }
  if (kernels.empty()) {
    roles.visualization = any_of(shown);
    roles.step = any_of(steps);
    return roles.step.empty() ? Roles{} : roles;
  }
  const NameSummary* rare = nullptr;
  for (const NameSummary& kernel : kernels) {
    if (speaks_of(kernel.text, {"render", "draw", "visuali"})) shown.push_back(kernel.text);
    const bool rarer = kernel.count >= 3 && 10 * kernel.count <= kernels.front().count;
    if (rarer && (rare == nullptr || kernel.median > rare->median)) rare = &kernel;
  }
  if (shown.empty() && roles.segment.empty() && rare != nullptr) shown.push_back(rare->text);
  roles.visualization = any_of(shown);
  roles.step = "kernel:.";  // a visualization that matches it, too, is one
  return roles;
}

}  // namespace evenstep
