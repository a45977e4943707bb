
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "catch.h"
#include "evenstep/device/hid/reference_device.h"
#include "units.h"

using namespace evenstep;
using namespace evenstep::test;
using namespace evenstep::reference_device;

namespace {

struct Field {
  char kind;  // 'I' input, 'O' output
  std::int64_t id, bits, count, usages, minimum, maximum, unit, exponent, flags;
  friend bool operator==(const Field&, const Field&) = default;
};

/// Just enough of HID 1.11 section 6.2.2 to add up the reports: it reads short items, keeps globals, and lets a main item
/// clear the usages.
std::vector<Field> fields_of(std::span<const std::byte> bytes) {
  std::vector<Field> fields;
  Field now{};
  int open_collections = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto prefix = std::to_integer<unsigned>(bytes[at]);
    const std::size_t size = (prefix & 3) == 3 ? 4 : prefix & 3;
    REQUIRE(at + 1 + size <= bytes.size());
    std::int64_t data = 0;
    for (std::size_t i = 0; i < size; ++i) data |= std::to_integer<std::int64_t>(bytes[at + 1 + i]) << (8 * i);
    const bool negative = size > 0 && data >> (8 * size - 1) != 0;
    const std::int64_t signed_data = negative ? data - (std::int64_t{1} << (8 * size)) : data;
    at += 1 + size;
    switch (prefix & 0xFC) {
      case 0x04:
        CHECK(data == 0xFF00);
        break;
      case 0x08:
        ++now.usages;
        break;
      case 0x14:
        now.minimum = signed_data;
        break;
      case 0x24:
        now.maximum = now.minimum < 0 ? signed_data : data;
        break;  // Linux reads it as unsigned if the minimum is not negative
      case 0x54:
        now.exponent = data < 8 ? data : data - 16;
        break;
      case 0x64:
        now.unit = data;
        break;
      case 0x74:
        now.bits = data;
        break;
      case 0x84:
        now.id = data;
        break;
      case 0x94:
        now.count = data;
        break;
      case 0xA0:
        ++open_collections;
        now.usages = 0;
        break;
      case 0xC0:
        --open_collections;
        break;
      case 0x80:
      case 0x90:
        REQUIRE(open_collections == 1);
        now.flags = data;
        now.kind = (prefix & 0xFC) == 0x80 ? 'I' : 'O';
        fields.push_back(now);
        now.usages = 0;
        break;
      default:
        FAIL("an item the reference device does not need: " << prefix);
    }
  }
  CHECK(open_collections == 0);
  return fields;
}

}  // namespace

TEST_CASE("the report descriptor's fields add up to the two reports") {
  std::map<std::pair<char, std::int64_t>, std::int64_t> bits;
  for (const Field& field : fields_of(report_descriptor())) bits[{field.kind, field.id}] += field.bits * field.count;
  const std::map<std::pair<char, std::int64_t>, std::int64_t> expected{{{'I', 1}, 8 * (kInputSize - 1)},
                                                                       {{'O', 2}, 8 * (kOutputSize - 1)}};
  CHECK(bits == expected);
}

TEST_CASE("the report descriptor declares range, unit and a usage of its own for every value") {
  const std::int64_t s = 0x1001, cm = 0x11, dyne = 0xE111, variable = 2;
  const std::vector<Field> expected{{'I', 1, 32, 1, 1, 0, 2 * kTwo31 - 1, 0, 0, variable},
                                    {'I', 1, 32, 1, 1, 0, 2 * kTwo31 - 1, s, -6, variable},
                                    {'I', 1, 32, 3, 3, -kTwo31, kTwo31 - 1, cm, -7, variable},
                                    {'O', 2, 32, 1, 1, 0, 2 * kTwo31 - 1, 0, 0, variable},
                                    {'O', 2, 32, 3, 3, -kTwo31, kTwo31 - 1, dyne, -1, variable}};
  CHECK(fields_of(report_descriptor()) == expected);
}

TEST_CASE("reports lie in memory byte for byte as documented") {
  const std::array<int, kInputSize> input{1, 0x04, 0x03, 0x02, 0x01, 0xFF, 0xFF, 0xFF, 0xFF, 0x01, 0,
                                          0, 0,    0xFE, 0xFF, 0xFF, 0xFF, 0x00, 0x00, 0x00, 0x80};
  const auto encoded = encode(InputReport{0x01020304, 0xFFFFFFFF, {1, -2, INT32_MIN}});
  for (std::size_t i = 0; i < kInputSize; ++i) CHECK(std::to_integer<int>(encoded[i]) == input[i]);
  const std::array<int, kOutputSize> output{2, 0xF0, 0xDE, 0xBC, 0x9A, 0xFF, 0xFF, 0xFF, 0x7F,
                                            0, 0,    0,    0,    0xFF, 0xFF, 0xFF, 0xFF};
  const auto encoded_output = encode(OutputReport{0x9ABCDEF0, {INT32_MAX, 0, -1}});
  for (std::size_t i = 0; i < kOutputSize; ++i) CHECK(std::to_integer<int>(encoded_output[i]) == output[i]);
}

TEST_CASE("100,000 random reports of each kind come back as they went") {
  std::mt19937_64 random(1);
  const auto word = [&] { return static_cast<std::uint32_t>(random()); };
  const auto number = [&] { return static_cast<std::int32_t>(word()); };
  for (int i = 0; i < 100'000; ++i) {
    const InputReport input{word(), word(), {number(), number(), number()}};
    const auto input_back = decode_input(encode(input));
    REQUIRE(input_back);
    REQUIRE((input_back->sequence == input.sequence && input_back->device_time_us == input.device_time_us &&
             input_back->position_nm == input.position_nm));
    const OutputReport output{word(), {number(), number(), number()}};
    const auto output_back = decode_output(encode(output));
    REQUIRE(output_back);
    REQUIRE((output_back->sequence == output.sequence && output_back->force_uN == output.force_uN));
  }
}

TEST_CASE("of all ids and lengths up to 64 exactly the right id with at least its length is decoded") {
  for (std::size_t size = 0; size <= 64; ++size) {
    for (int id = 0; id < 256; ++id) {
      std::vector<std::byte> bytes(size, std::byte{0x5A});
      if (size > 0) bytes[0] = static_cast<std::byte>(id);
      REQUIRE(decode_input(bytes).has_value() == (size >= 21 && id == 1));
      REQUIRE(decode_output(bytes).has_value() == (size >= 17 && id == 2));
    }
  }
}

TEST_CASE("a longer report is decoded from its head") {
  const InputReport report{7, 8, {9, 10, 11}};
  const auto exact = encode(report);
  std::vector<std::byte> longer(exact.begin(), exact.end());
  longer.resize(40, std::byte{0xEE});
  const auto back = decode_input(longer);
  REQUIRE(back);
  CHECK((back->sequence == 7 && back->device_time_us == 8 && back->position_nm == report.position_nm));
}

TEST_CASE("units are rounded to the nearest, ties away from zero") {
  int exact_ties = 0;
  for (int k = -5000; k < 5000; ++k) {
    const double tie = (k + 0.5) / 1e9;
    const std::int32_t away = k < 0 ? k : k + 1;
    if (tie * 1e9 == k + 0.5) {
      ++exact_ties;
      REQUIRE(to_nm({tie, 0, 0})[0] == away);
    }
    REQUIRE(to_nm({0, (k + 0.49) / 1e9, 0})[1] == k);
    REQUIRE(to_nm({0, 0, (k + 0.51) / 1e9})[2] == k + 1);
    REQUIRE(to_uN({k / 1e6, (k + 0.49) / 1e6, (k + 0.51) / 1e6}) == std::array<std::int32_t, 3>{k, k, k + 1});
  }
  CHECK(exact_ties > 5000);
}

TEST_CASE("units saturate at the ends of int32 and nowhere before") {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double beyond : {2.147483648, 2.1474836475, 3.0, 1e300, infinity}) {
    CHECK(to_nm({beyond, -beyond - 1e-9, 0}) == std::array<std::int32_t, 3>{INT32_MAX, INT32_MIN, 0});
    CHECK(to_uN({0, beyond * 1000, -beyond * 1000 - 1e-6}) == std::array<std::int32_t, 3>{0, INT32_MAX, INT32_MIN});
  }
  for (std::int32_t inside = 0; inside < 1000; ++inside) {
    const std::int32_t high = INT32_MAX - inside, low = INT32_MIN + inside;
    CHECK(to_nm({high / 1e9, low / 1e9, 0}) == std::array<std::int32_t, 3>{high, low, 0});
    CHECK(to_uN({high / 1e6, low / 1e6, 0}) == std::array<std::int32_t, 3>{high, low, 0});
  }
}
