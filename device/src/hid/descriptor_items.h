#pragma once
/// Writes report descriptors of simulated devices, item by item.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

namespace evenstep::internal {

/// Appends items, each with as few bytes as its value needs.
class Items {
 public:
  std::vector<std::byte> bytes;

  void item(int tag, std::int64_t value, int size) {
    bytes.push_back(static_cast<std::byte>(tag | (size == 4 ? 3 : size)));
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
  }
  void item(int tag, std::int64_t value) { item(tag, value, value < 0x100 ? 1 : value < 0x10000 ? 2 : 4); }
  void signed_item(int tag, std::int64_t value) {
    item(tag, value, value >= -0x80 && value < 0x80 ? 1 : value >= -0x8000 && value < 0x8000 ? 2 : 4);
  }

  void page(int page) { item(0x04, page); }
  void usage(int usage) { item(0x08, usage); }
  void usages(std::initializer_list<int> list) {
    for (const int one : list) usage(one);
  }
  void open(int usage_of_it) {
    usage(usage_of_it);
    item(0xA0, 2);
  }
  void open_report(int usage_of_it, int id) {
    open(usage_of_it);
    item(0x84, id);
  }
  void close() { item(0xC0, 0, 0); }
  void logical(std::int64_t minimum, std::int64_t maximum) {
    signed_item(0x14, minimum);
    minimum < 0 ? signed_item(0x24, maximum) : item(0x24, maximum);
  }
  void physical(std::int64_t minimum, std::int64_t maximum) {
    signed_item(0x34, minimum);
    minimum < 0 ? signed_item(0x44, maximum) : item(0x44, maximum);
  }
  void unit(int unit, int exponent_byte) {
    item(0x64, unit);
    item(0x54, exponent_byte);
  }
  void format(int bits, int count) {
    item(0x74, bits);
    item(0x94, count);
  }
  void input(int flags) { item(0x80, flags); }
  void output(int flags) { item(0x90, flags); }
  void feature(int flags) { item(0xB0, flags); }
};

}  // namespace evenstep::internal
