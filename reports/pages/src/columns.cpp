#include "src/columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "evenstep/time/library_on_demand.h"

namespace evenstep::internal {
namespace {

constexpr std::int64_t kMostDifference = std::int64_t{1} << 30;  // so that second differences fit 32 bits, too

std::vector<std::int64_t> differences(std::vector<std::int64_t> values) {
  for (std::size_t i = values.size(); i-- > 1;) values[i] -= values[i - 1];
  if (!values.empty()) values[0] = 0;
  return values;
}

double length(const std::vector<std::int64_t>& values) {
  double sum = 0;
  for (const std::int64_t value : values) sum += std::log2(1 + std::abs(static_cast<double>(value)));
  return sum;
}

std::int64_t largest(const std::vector<std::int64_t>& values) {
  std::int64_t most = 0;
  for (const std::int64_t value : values) most = std::max(most, std::abs(value));
  return most;
}

/// All lowest bytes, then all second ones, ...
std::string shuffled(const std::vector<std::int64_t>& values) {
  std::string out;
  out.reserve(4 * values.size());
  for (int shift = 0; shift < 32; shift += 8) {
    for (const std::int64_t value : values) out += static_cast<char>(static_cast<std::uint64_t>(value) >> shift & 0xFF);
  }
  return out;
}

/// Packed by zlib, if it is installed.
std::optional<std::string> packed(const std::string& bytes) {
  using Bound = unsigned long (*)(unsigned long);
  using Compress = int (*)(unsigned char*, unsigned long*, const unsigned char*, unsigned long, int);
  static Bound bound = nullptr;
  static Compress compress = nullptr;
  static const bool there = !load_on_demand("libz.so.1", {{"compressBound", reinterpret_cast<void**>(&bound)},
                                                          {"compress2", reinterpret_cast<void**>(&compress)}});
  if (!there) return std::nullopt;
  unsigned long size = bound(bytes.size());
  std::string out(size, '\0');
  constexpr int kLevel = 6;
  const int status = compress(reinterpret_cast<unsigned char*>(out.data()), &size,
                              reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), kLevel);
  if (status != 0) return std::nullopt;
  out.resize(size);
  return out;
}

}  // namespace

int Columns::put(const std::vector<std::int64_t>& values, double quantum, std::vector<std::size_t> gaps) {
  const std::vector<std::int64_t> first = differences(values);
  const std::vector<std::int64_t> second = differences(first);
  const bool twice = values.size() > 2 && largest(second) <= kMostDifference && length(second) < length(first);
  const std::string stored = shuffled(twice ? second : first);
  Json column = {{"count", values.size()},
                 {"first", values.empty() ? 0 : values.front()},
                 {"order", twice ? 2 : 1},
                 {"quantum", quantum},
                 {"gaps", std::move(gaps)}};
  for (std::size_t i = 0; i < list_.size(); ++i) {
    if (stored_[i] == stored && list_[i] == column) return static_cast<int>(i);
  }
  bytes_ += stored;
  stored_.push_back(stored);
  list_.push_back(std::move(column));
  return static_cast<int>(list_.size()) - 1;
}

int Columns::add(std::span<const std::int64_t> values) {
  const std::vector<std::int64_t> whole(values.begin(), values.end());
  const std::int64_t most = largest(differences(whole));
  if (most <= kMostDifference) return put(whole, 1, {});
  const std::int64_t quantum = most / kMostDifference + 1;  // a pause of more than a second: to so many ns
  std::vector<std::int64_t> rounded;
  for (const std::int64_t value : whole) rounded.push_back(value / quantum);
  return put(rounded, static_cast<double>(quantum), {});
}

int Columns::add(std::span<const double> values) {
  constexpr double kHuge = 1e200;  // beyond it a difference may overflow
  std::vector<std::size_t> gaps;
  double low = INFINITY, high = -INFINITY, jump = 0, before = NAN;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(std::abs(values[i]) < kHuge)) {
      gaps.push_back(i);
      continue;
    }
    low = std::min(low, values[i]);
    high = std::max(high, values[i]);
    if (!std::isnan(before)) jump = std::max(jump, std::abs(values[i] - before));
    before = values[i];
  }
  double quantum = high > low ? std::max(std::ldexp(high - low, -40), std::ldexp(jump, -29)) : std::abs(high);
  if (!(quantum > 0) || !std::isfinite(quantum)) quantum = 1;  // all values are 0, or none is finite
  // Whole multiples must fit 53 bits, otherwise the page could not read them.
  if (low <= high) quantum = std::max(quantum, std::ldexp(std::max(std::abs(low), std::abs(high)), -52));
  std::vector<std::int64_t> whole;
  std::int64_t last = 0;
  for (const double value : values) {
    if (std::abs(value) < kHuge) last = static_cast<std::int64_t>(std::nearbyint(value / quantum));
    whole.push_back(last);
  }
  return put(whole, quantum, std::move(gaps));
}

Json Columns::json() const {
  const std::optional<std::string> small = packed(bytes_);
  return {{"list", list_}, {"packed", small.has_value()}, {"bytes", base64(small ? *small : bytes_)}};
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t at) { return at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0U; };
    const unsigned three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    const std::size_t present = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t letter = 0; letter < 4; ++letter)
      out += letter <= present ? kLetters[three >> (18 - 6 * letter) & 63] : '=';
  }
  return out;
}

}  // namespace evenstep::internal
