// One recording in several encodings: a CSV with commas, one with semicolons and decimal commas, tabs, UTF-16, trace events
// as complete ones and as begins and ends. All must give the same intervals.
#include "evenstep/recordings/profile.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct Slice {
  char name;
  std::int64_t begin_us, length_us;
};

/// Slices of one thread, which follow each other; each may hold a shorter one.
std::vector<Slice> slices_of(const std::uint8_t* data, std::size_t size) {
  std::vector<Slice> all;
  std::int64_t at = 0;
  for (std::size_t i = 0; i + 3 <= size && all.size() < 300; i += 3) {
    at += data[i] * (data[i] % 5 == 0 ? 1000 : 1);
    const std::int64_t length = 3 + data[i + 1] * 7;
    all.push_back({static_cast<char>('a' + data[i + 2] % 7), at, length});
    if (data[i + 2] >= 128) all.push_back({'z', at + 1, length - 2});
    at += length;
  }
  return all;
}

/// Microseconds in ms, with 3 digits behind the sign, and separators between thousands where `between` is not 0.
std::string in_ms(std::int64_t us, char sign, char between) {
  std::string whole = std::to_string(us / 1000);
  for (std::size_t i = whole.size(); between != 0 && i > 3; i -= 3) whole.insert(i - 3, 1, between);
  const std::string part = std::to_string(1000 + us % 1000).substr(1);
  // One more digit: what has three may stand between thousands.
  return whole + sign + part + "0";
}

std::string csv_of(const std::vector<Slice>& slices, char separator, char sign, char between) {
  std::string all = std::string("Name") + separator + "Start (ms)" + separator + "Duration (ms)" + separator + "TID\n";
  for (const Slice& one : slices)
    all += std::string(1, one.name) + separator + in_ms(one.begin_us, sign, between) + separator +
           in_ms(one.length_us, sign, 0) + separator + "1\n";
  return all;
}

std::string utf16(const std::string& ascii) {
  std::string all = "\xFF\xFE";
  for (const char c : ascii) (all += c) += '\0';
  return all;
}

std::string event(char phase, const Slice& slice, std::int64_t at) {
  return std::string("{\"ph\":\"") + phase + "\",\"pid\":1,\"tid\":1,\"name\":\"" + slice.name +
         "\",\"ts\":" + std::to_string(at) + (phase == 'X' ? ",\"dur\":" + std::to_string(slice.length_us) : "") + "}";
}

std::string complete_events(const std::vector<Slice>& slices) {
  std::string all;
  for (std::size_t i = slices.size(); i-- > 0;) all += (all.empty() ? "[" : ",") + event('X', slices[i], slices[i].begin_us);
  return all + "]";
}

std::string begins_and_ends(const std::vector<Slice>& slices) {
  std::string all;
  const auto add = [&](char phase, const Slice& slice, std::int64_t at) {
    all += (all.empty() ? "[" : ",") + event(phase, slice, at);
  };
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const bool holds = i + 1 < slices.size() && slices[i + 1].name == 'z';
    add('B', slices[i], slices[i].begin_us);
    if (holds) add('B', slices[i + 1], slices[i + 1].begin_us);
    if (holds) add('E', slices[i + 1], slices[i + 1].begin_us + slices[i + 1].length_us);
    add('E', slices[i], slices[i].begin_us + slices[i].length_us);
    i += holds;
  }
  return all + "]";
}

std::string intervals_of(const std::string& bytes) {
  const ProfileResult profile = parse_profile(bytes, "x");
  require(profile.ok(), "what was written is not read: " + (profile ? "" : text(profile.error().front())));
  require(profile->left_out.empty() && profile->clipped.count == 0, "a whole recording is damaged");
  std::string all;
  for (const ProfileInterval& one : profile->intervals)
    all += profile->names[one.name].text + " " + std::to_string(one.begin.ns) + " " + std::to_string(one.end.ns) + "\n";
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<Slice> slices = slices_of(data, size);
  if (slices.empty()) return 0;
  const std::string read = intervals_of(complete_events(slices));
  const std::string plain = csv_of(slices, ',', '.', 0), german = csv_of(slices, ';', ',', '.');
  for (const std::string& bytes : {begins_and_ends(slices), plain, german, csv_of(slices, '\t', '.', ' '), utf16(plain),
                                   utf16(german), "a notice, of a tool\n\n" + german})
    require(intervals_of(bytes) == read, "two encodings of one recording differ:\n" + bytes.substr(0, 2000));
  return 0;
}
