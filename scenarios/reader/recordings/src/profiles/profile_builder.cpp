#include "profile_builder.h"

#include <fmt/format.h>

namespace evenstep::internal {
namespace {

/// At most kLongestName bytes, not ending within a character of UTF-8.
std::string_view shortened(std::string_view text) {
  if (text.size() <= kLongestName) return text;
  std::size_t length = kLongestName;
  while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80) --length;
  return text.substr(0, length);
}

}  // namespace

/// Names are shown on terminals, and stand in regular expressions.
std::string ProfileBuilder::shown(std::string_view text) {
  std::string plain(shortened(text));
  for (char& c : plain) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return plain;
}

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

std::uint32_t ProfileBuilder::source(const std::string& text) {
  const auto found = sources_.find(text);
  if (found != sources_.end()) return found->second;
  if (sources_.size() >= kMostNames / 100) {
    if (!failed()) fail(fmt::format("more than {} processes", kMostNames / 100));
    return 0;
  }
  const auto index = static_cast<std::uint32_t>(profile_.sources.size());
  profile_.sources.push_back(text);
  sources_.emplace(text, index);
  return index;
}

std::uint32_t ProfileBuilder::track(std::string_view source_text, std::string_view lane, TrackOrder order) {
  auto& tracks = tracks_[static_cast<std::size_t>(order)];
  std::pair<std::string, std::string> key{shown(source_text), shown(lane.substr(0, 100))};
  const auto found = tracks.find(key);
  if (found != tracks.end()) return found->second;
  if (profile_.tracks.size() >= kMostTracks) {
    if (!failed()) fail(fmt::format("more than {} threads and queues", kMostTracks));
    return 0;
  }
  const auto index = static_cast<std::uint32_t>(profile_.tracks.size());
  profile_.tracks.push_back({source(key.first), key.second, order});
  tracks.emplace(std::move(key), index);
  return index;
}

void ProfileBuilder::add(std::uint32_t name, std::uint32_t track, std::int64_t begin_ns, std::int64_t end_ns) {
  if (failed()) return;
  if (end_ns < begin_ns) return leave_out("intervals that end before they begin", profile_.names[name].text);
  if (profile_.intervals.size() >= kMostIntervals)
    return fail(fmt::format("more than {} intervals; export a part of the recording", kMostIntervals));
  profile_.intervals.push_back({{begin_ns}, {end_ns}, name, track});
}

void ProfileBuilder::leave_out(std::string_view what, std::string_view first, bool on_purpose, std::int64_t count) {
  const auto [found, is_new] = left_out_.try_emplace(std::string(what), profile_.left_out.size());
  if (is_new) profile_.left_out.push_back({std::string(what), 0, shown(first.substr(0, 100)), on_purpose});
  profile_.left_out[found->second].count += count;
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
  const std::int64_t twice = mend_tracks(profile_);
  if (twice > 0) profile_.left_out.push_back({"intervals that are there twice", twice, "", false});
  return std::move(profile_);
}

}  // namespace evenstep::internal
