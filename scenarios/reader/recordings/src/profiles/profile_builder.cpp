#include "profile_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

namespace evenstep::internal {
namespace {

/// At most kLongestName bytes, not ending within a character of UTF-8.
std::string_view shortened(std::string_view text) {
  if (text.size() <= kLongestName) return text;
  std::size_t length = kLongestName;
  while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80) --length;
  return text.substr(0, length);
}

/// Without control characters: names are shown on terminals, and stand in regular expressions.
std::string shown(std::string_view text) {
  std::string plain(shortened(text));
  for (char& c : plain) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return plain;
}

}  // namespace

std::uint32_t ProfileBuilder::name(std::string_view text, std::string_view category) {
  std::pair<std::string, std::string> key{shown(text), shown(category)};
  const auto found = names_.find(key);
  if (found != names_.end()) return found->second;
  name_bytes_ += key.first.size() + key.second.size();
  if (names_.size() >= kMostNames || name_bytes_ > kMostNameBytes) {
    if (!failed()) fail(fmt::format("more than {} different names, or {} bytes of them", kMostNames, kMostNameBytes));
    return 0;
  }
  const auto index = static_cast<std::uint32_t>(profile_.names.size());
  profile_.names.push_back({key.first, key.second});
  names_.emplace(std::move(key), index);
  return index;
}

std::uint32_t ProfileBuilder::source(std::string_view text) {
  const std::string plain = shown(text);
  const auto found = sources_.find(plain);
  if (found != sources_.end()) return found->second;
  if (sources_.size() >= kMostNames / 100) {
    if (!failed()) fail(fmt::format("more than {} processes", kMostNames / 100));
    return 0;
  }
  const auto index = static_cast<std::uint32_t>(profile_.sources.size());
  profile_.sources.push_back(plain);
  sources_.emplace(plain, index);
  return index;
}

void ProfileBuilder::add(std::uint32_t name, std::uint32_t source, std::int64_t begin_ns, std::int64_t end_ns) {
  if (failed()) return;
  if (end_ns < begin_ns) return leave_out("intervals that end before they begin", profile_.names[name].text);
  if (profile_.intervals.size() >= kMostIntervals)
    return fail(fmt::format("more than {} intervals; export a part of the recording", kMostIntervals));
  profile_.intervals.push_back({{begin_ns}, {end_ns}, name, source});
}

void ProfileBuilder::leave_out(std::string_view what, std::string_view first) {
  const auto [found, is_new] = left_out_.try_emplace(std::string(what), profile_.left_out.size());
  if (is_new) profile_.left_out.push_back({std::string(what), 0, shown(first.substr(0, 100))});
  ++profile_.left_out[found->second].count;
}

void ProfileBuilder::fail(std::string message, std::int64_t line, std::int64_t column) {
  errors_.push_back({profile_.file, line, column, std::move(message)});
}

ProfileResult ProfileBuilder::finish() {
  if (failed()) return Failure(std::move(errors_));
  if (profile_.intervals.empty()) {
    std::string message = fmt::format("{}: there is no interval in it", profile_.format);
    for (const LeftOut& left : profile_.left_out)
      message += fmt::format("; left out: {} {}, the first '{}'", left.count, left.what, left.first);
    return Failure(std::vector<Diagnostic>{{profile_.file, 0, 0, message}});
  }
  std::sort(profile_.intervals.begin(), profile_.intervals.end(), [](const ProfileInterval& a, const ProfileInterval& b) {
    return std::tie(a.begin, a.end, a.name, a.source) < std::tie(b.begin, b.end, b.name, b.source);
  });
  return std::move(profile_);
}

}  // namespace evenstep::internal
