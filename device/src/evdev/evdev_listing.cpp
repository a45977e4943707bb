#include "evdev_listing.h"

#include <cstdint>
#include <cstdlib>

#include "../printable.h"

namespace evenstep::internal {
namespace {

constexpr unsigned kConstantBit = evdev::kConstant, kSpringBit = evdev::kSpring, kGainBit = evdev::kGain;

std::uint16_t hexadecimal(const std::string& text) {
  return static_cast<std::uint16_t>(std::strtoul(text.c_str(), nullptr, 16));
}

/// Whether a bit is set in a mask: words in hexadecimal, the highest first, without leading zeros.
bool has_bit(const std::string& mask, unsigned bit) {
  constexpr unsigned kBits = sizeof(long) * 8;
  std::size_t end = mask.size();
  for (unsigned word = 0; word < bit / kBits; ++word) {
    const std::size_t space = end == 0 ? std::string::npos : mask.find_last_of(' ', end - 1);
    if (space == std::string::npos) return false;
    end = space;
  }
  const std::size_t space = end == 0 ? std::string::npos : mask.find_last_of(' ', end - 1);
  const std::size_t begin = space == std::string::npos ? 0 : space + 1;
  const std::string word = mask.substr(begin, end - begin);
  return (std::strtoull(word.c_str(), nullptr, 16) >> (bit % kBits) & 1) != 0;
}

}  // namespace

EvdevListing evdev_listing(const EvdevTexts& texts) {
  const bool plays = has_effects(texts);
  EvdevListing listing{
      .info = {"", printable(texts.name), hexadecimal(texts.vendor), hexadecimal(texts.product), printable(texts.serial)},
      .constant = plays && has_bit(texts.effects, kConstantBit),
      .spring = plays && has_bit(texts.effects, kSpringBit),
      .gain = plays && has_bit(texts.effects, kGainBit)};
  for (unsigned axis = 0; axis < 3; ++axis) listing.has_axis[axis] = has_bit(texts.axes, axis);
  return listing;
}

bool has_effects(const EvdevTexts& texts) {
  return has_bit(texts.types, evdev::kFf) && texts.effects.find_first_of("123456789abcdef") != std::string::npos;
}

}  // namespace evenstep::internal
