#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "catch.h"
#include "evenstep/device/hid/report_descriptor.h"
#include "units.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

FieldLayout field_of(std::uint32_t bits, std::uint32_t bit_offset, std::int64_t minimum, std::int64_t maximum,
                     std::uint32_t count = 1) {
  FieldLayout field;
  field.type = ReportType::output;
  field.id = 7;
  field.bits = bits;
  field.bit_offset = bit_offset;
  field.count = count;
  field.logical_minimum = minimum;
  field.logical_maximum = maximum;
  return field;
}

/// A field with the full range of `bits` bits.
FieldLayout full_field(std::uint32_t bits, std::uint32_t bit_offset, bool is_signed, std::uint32_t count = 1) {
  const std::int64_t range = std::int64_t{1} << bits;
  return is_signed ? field_of(bits, bit_offset, -range / 2, range / 2 - 1, count)
                   : field_of(bits, bit_offset, 0, range - 1, count);
}

using Report = std::array<std::byte, 16>;

bool bit(const Report& report, std::size_t index) {
  return (std::to_integer<unsigned>(report[index / 8]) >> (index % 8) & 1) != 0;
}

/// Reads one bit after the other.
std::int64_t oracle(const Report& report, std::size_t first, std::uint32_t bits, bool is_signed) {
  std::int64_t value = 0;
  for (std::uint32_t i = 0; i < bits; ++i) value += bit(report, first + i) ? std::int64_t{1} << i : 0;
  return is_signed && bit(report, first + bits - 1) ? value - (std::int64_t{1} << bits) : value;
}

Report noise(std::mt19937_64& random) {
  Report report;
  for (std::byte& byte : report) byte = static_cast<std::byte>(random() & 0xFF);
  return report;
}

/// Sets a value, reads it back, and checks that no other bit has changed.
void require_round_trip(Report report, const FieldLayout& field, std::uint32_t index, std::int64_t value) {
  const Report before = report;
  const std::size_t first = 8 + field.bit_offset + index * field.bits;
  REQUIRE(set(report, field, index, value));
  REQUIRE(get(report, field, index) == value);
  REQUIRE(oracle(report, first, field.bits, field.logical_minimum < 0) == value);
  for (std::size_t i = 0; i < 8 * report.size(); ++i) {
    if (i < first || i >= first + field.bits) REQUIRE(bit(report, i) == bit(before, i));
  }
}

}  // namespace

TEST_CASE("every value of 1 to 8 bits at every offset of three bytes is set and got and moves no other bit") {
  std::mt19937_64 random(1);
  for (std::uint32_t bits = 1; bits <= 8; ++bits) {
    for (std::uint32_t offset = 0; offset < 24; ++offset) {
      for (const bool is_signed : {false, true}) {
        const FieldLayout field = full_field(bits, offset, is_signed);
        for (std::int64_t value = field.logical_minimum; value <= field.logical_maximum; ++value) {
          require_round_trip(noise(random), field, 0, value);
        }
      }
    }
  }
}

TEST_CASE("values of 9 to 32 bits at every offset and index: the ends and 40 random ones") {
  std::mt19937_64 random(2);
  for (std::uint32_t bits = 9; bits <= 32; ++bits) {
    for (std::uint32_t offset = 0; offset < 24; ++offset) {
      for (const bool is_signed : {false, true}) {
        const FieldLayout field = full_field(bits, offset, is_signed, 3);
        const std::uint64_t span = std::uint64_t{1} << bits;
        for (std::uint32_t index = 0; index < 3; ++index) {
          require_round_trip(noise(random), field, index, field.logical_minimum);
          require_round_trip(noise(random), field, index, field.logical_maximum);
        }
        for (int i = 0; i < 40; ++i) {
          const auto value = field.logical_minimum + static_cast<std::int64_t>(random() % span);
          require_round_trip(noise(random), field, static_cast<std::uint32_t>(random() % 3), value);
        }
      }
    }
  }
}

TEST_CASE("what a field cannot hold is refused and leaves the report as it was: range 3 to 6 in 2 to 8 bits") {
  for (std::uint32_t bits = 2; bits <= 8; ++bits) {
    const FieldLayout field = field_of(bits, 3, 3, 6);
    for (std::int64_t value = -300; value <= 300; ++value) {
      Report report{};
      const bool fits = value >= 3 && value <= 6 && value < std::int64_t{1} << bits;
      REQUIRE(can_hold(field, value) == fits);
      REQUIRE(set(report, field, 0, value) == fits);
      if (!fits) REQUIRE(report == Report{});
      REQUIRE(nearest(field, value) == std::clamp<std::int64_t>(value, 3, bits == 2 ? 3 : 6));
    }
  }
  // 4 to 6 needs three bits. Two bits can hold none of these values.
  CHECK_FALSE(nearest(field_of(2, 0, 4, 6), 5));
  CHECK_FALSE(nearest(field_of(0, 0, 0, 0), 0));
}

TEST_CASE("bits outside the logical range are got as they are and set only raw") {
  const FieldLayout field = field_of(16, 0, 0, 32767);
  Report report{};
  CHECK_FALSE(set(report, field, 0, 0xFFFF));
  CHECK(set_raw(report, field, 0, 0xFFFF));
  CHECK(get(report, field) == 0xFFFF);
}

TEST_CASE("no value lies in a report too short by one byte or past the last index or in more than 32 bits") {
  for (std::uint32_t bits = 1; bits <= 32; ++bits) {
    for (std::uint32_t offset = 0; offset < 16; ++offset) {
      const FieldLayout field = full_field(bits, offset, false, 2);
      const std::size_t needed = 1 + (offset + 2 * bits + 7) / 8;
      for (std::size_t size = 0; size <= 16; ++size) {
        Report report{};
        const auto part = std::span(report).first(size);
        REQUIRE(get(part, field, 1).has_value() == (size >= needed));
        REQUIRE(set(part, field, 1, 1) == (size >= needed));
        REQUIRE_FALSE(get(part, field, 2));
      }
    }
  }
  Report report{};
  for (const std::uint32_t bits : {0u, 33u, 64u, 256u}) {
    CHECK_FALSE(get(report, field_of(bits, 0, 0, 1)));
    CHECK_FALSE(set_raw(report, field_of(bits, 0, 0, 1), 0, 1));
  }
}

TEST_CASE("only an input report without an id has no byte before its fields") {
  Report report{};
  report[0] = std::byte{0x11};
  report[1] = std::byte{0x22};
  for (const ReportType type : {ReportType::input, ReportType::output, ReportType::feature}) {
    for (const std::uint8_t id : {0, 1, 255}) {
      FieldLayout field = full_field(8, 0, false);
      field.type = type;
      field.id = id;
      CHECK(get(report, field) == (type == ReportType::input && id == 0 ? 0x11 : 0x22));
    }
  }
}

TEST_CASE("an array selects by its place in the usage list from the logical minimum on") {
  for (std::int64_t minimum = -3; minimum <= 3; ++minimum) {
    HidField array;
    static_cast<FieldLayout&>(array) = field_of(8, 0, minimum, minimum + 4);
    for (const std::uint32_t usage : {10, 20, 30, 20, 50, 60}) array.usages.add(usage);
    const std::vector<std::uint32_t> first_of{10, 20, 30, 50};
    for (const std::uint32_t usage : first_of) {
      const auto value = selector(array, usage);
      REQUIRE(value);
      CHECK(selected(array, *value) == usage);
    }
    CHECK(selected(array, minimum + 3) == 20u);
    CHECK_FALSE(selected(array, minimum - 1));
    CHECK_FALSE(selected(array, minimum + 5));
    CHECK_FALSE(selector(array, 60));  // beyond the logical maximum
    CHECK_FALSE(selector(array, 70));
  }
}

TEST_CASE("logical and physical values turn into one another for every exponent of a nibble") {
  for (std::int32_t exponent = -8; exponent <= 7; ++exponent) {
    FieldLayout field = field_of(16, 0, -1000, 1000);
    field.physical_minimum = -90;
    field.physical_maximum = 110;
    field.unit_exponent = exponent;
    for (std::int64_t logical = -1000; logical <= 1000; ++logical) {
      // 0.1 per count from 10 on; a few roundings of a double.
      const double expected = (static_cast<double>(logical) / 10 + 10) * std::pow(10, exponent);
      REQUIRE(std::abs(to_physical(field, logical) - expected) <= 1e-15 * 120 * std::pow(10, exponent));
      REQUIRE(to_logical(field, to_physical(field, logical)) == logical);
      REQUIRE(to_logical(field, (static_cast<double>(logical) / 10 + 10.049) * std::pow(10, exponent)) == logical);
    }
    CHECK(to_logical(field, 1e30) == 1000);
    CHECK(to_logical(field, -1e30) == -1000);
    CHECK_FALSE(to_logical(field, kInfinity));
    CHECK_FALSE(to_logical(field, -kInfinity));
    CHECK_FALSE(to_logical(field, std::nan("")));
  }
}

TEST_CASE("without a physical range the logical one counts: nanometres of the reference device") {
  FieldLayout field = field_of(32, 0, -kTwo31, kTwo31 - 1);
  field.unit_exponent = -7;  // 1e-7 centimetres
  for (const std::int64_t nm : {-kTwo31, std::int64_t{-1}, std::int64_t{0}, std::int64_t{123'456'789}, kTwo31 - 1}) {
    CHECK(to_physical(field, nm) == static_cast<double>(nm) / 1e7);
    CHECK(to_logical(field, static_cast<double>(nm) / 1e7) == nm);
  }
}

TEST_CASE("empty ranges and senseless exponents give numbers or nothing and no trap") {
  for (const std::int32_t exponent : {INT32_MIN, -400, 0, 400, INT32_MAX}) {
    for (const std::int64_t width : {0, 1, 100}) {
      FieldLayout field = field_of(16, 0, 5, 5 + width);
      field.physical_minimum = 7;
      field.physical_maximum = 7;
      field.unit_exponent = exponent;
      for (const double physical : {-1e300, -1.0, 0.0, 1.0, 1e300}) {
        const auto logical = to_logical(field, physical);
        if (logical) CHECK(can_hold(field, *logical));
      }
      CHECK_FALSE(std::isnan(to_physical(field, 5)));
    }
  }
}
