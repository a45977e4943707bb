#include "evenstep/device/hid/report_descriptor.h"

#include <array>
#include <random>
#include <string>
#include <tuple>

#include "cases.h"
#include "catch.h"
#include "descriptor_items.h"
#include "evenstep/device/hid/reference_device.h"
#include "units.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

ReportDescriptor parsed(const Bytes& bytes) {
  auto result = parse_report_descriptor(bytes);
  INFO((result ? "" : result.error().message));
  REQUIRE(result);
  return *std::move(result);
}

/// Parses these items with a usage page before them, in an application collection.
ReportDescriptor parsed_items(std::initializer_list<int> items) {
  Bytes bytes = bytes_of({0x05, 0x01, 0x09, 0x04, 0xA1, 0x01});
  for (const std::byte byte : bytes_of(items)) bytes.push_back(byte);
  bytes.push_back(std::byte{0xC0});
  return parsed(bytes);
}

/// The usages: one for each element, and those that an array has beyond its elements.
std::vector<std::uint32_t> usages_of(const HidField& field) {
  std::vector<std::uint32_t> usages;
  for (std::uint32_t i = 0; i < std::max(field.count, field.usages.size()); ++i) usages.push_back(field.usages[i]);
  return usages;
}

struct Malformed {
  const char* what;
  Bytes bytes;
  std::size_t offset;
  const char* message;
};

Bytes repeated(std::initializer_list<int> items, int times) {
  Bytes bytes;
  for (int i = 0; i < times; ++i) {
    for (const std::byte byte : bytes_of(items)) bytes.push_back(byte);
  }
  return bytes;
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

TEST_CASE("the reference device's descriptor gives its documented fields") {
  const auto result = parse_report_descriptor(reference_device::report_descriptor());
  REQUIRE(result);
  const ReportDescriptor& descriptor = *result;
  CHECK(descriptor.collections == std::vector<HidCollection>{{1, 0xFF000001, -1}});
  CHECK(descriptor.reports == std::vector<HidReport>{{ReportType::input, 1, 160}, {ReportType::output, 2, 128}});
  CHECK(descriptor.report(ReportType::input, 1)->size() == reference_device::kInputSize);
  CHECK(descriptor.report(ReportType::output, 2)->size() == reference_device::kOutputSize);
  CHECK(descriptor.report(ReportType::input, 2) == nullptr);

  const auto field = [](ReportType type, std::uint8_t id, std::uint32_t offset, std::int64_t minimum, std::int64_t maximum,
                        std::int32_t exponent, std::uint32_t unit, std::vector<std::uint32_t> usages) {
    HidField f;
    static_cast<FieldLayout&>(f) = {type, id, offset,   32,  static_cast<std::uint32_t>(usages.size()), 2, minimum, maximum,
                                    0,    0,  exponent, unit};
    for (const std::uint32_t usage : usages) f.usages.add(usage);
    f.collection = 0;
    return f;
  };
  const std::int64_t u32 = 2 * kTwo31 - 1;
  const std::vector<HidField> expected{
      field(ReportType::input, 1, 0, 0, u32, 0, 0, {0xFF000002}),
      field(ReportType::input, 1, 32, 0, u32, -6, 0x1001, {0xFF000003}),
      field(ReportType::input, 1, 64, -kTwo31, kTwo31 - 1, -7, 0x11, {0xFF000004, 0xFF000005, 0xFF000006}),
      field(ReportType::output, 2, 0, 0, u32, 0, 0, {0xFF000002}),
      field(ReportType::output, 2, 32, -kTwo31, kTwo31 - 1, -1, 0xE111, {0xFF000007, 0xFF000008, 0xFF000009})};
  CHECK(descriptor.fields == expected);
}

TEST_CASE("the reference device's reports are read and written by usage as its own codec does") {
  const ReportDescriptor descriptor = *parse_report_descriptor(reference_device::report_descriptor());
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto word = [&] { return static_cast<std::int32_t>(random()); };
    const reference_device::InputReport input{
        static_cast<std::uint32_t>(word()), static_cast<std::uint32_t>(word()), {word(), word(), word()}};
    const auto bytes = reference_device::encode(input);
    const auto value = [&](std::uint32_t usage) {
      const auto element = descriptor.find(ReportType::input, 1, 0xFF000000 + usage);
      return *get(bytes, *element->field, element->index);
    };
    REQUIRE((value(2) == input.sequence && value(3) == input.device_time_us));
    for (std::uint32_t axis = 0; axis < 3; ++axis) REQUIRE(value(4 + axis) == input.position_nm[axis]);
  }
}

TEST_CASE("every kind of malformed descriptor is refused at its byte") {
  const Bytes page = bytes_of({0x05, 0x01});
  const Bytes open = bytes_of({0xA1, 0x01});
  const std::array<Malformed, 30> rows{{
      {"empty", {}, 0, "1 to 4096 bytes, not 0"},
      {"4097 bytes", repeated({0xC0}, 4097), 0, "not 4097"},
      {"long item", bytes_of({0x05, 0x01, 0xFE, 0x02, 0x10, 1, 2}), 2, "long item (FE)"},
      {"long tag of another type", bytes_of({0xF4}), 0, "long item (F4)"},
      {"one byte missing", bytes_of({0x05}), 1, "the item at byte 0 (05) has 1 data bytes, but only 0 follow"},
      {"of two one missing", bytes_of({0xA4, 0x06, 0x00}), 3, "the item at byte 1 (06) has 2 data bytes, but only 1 follow"},
      {"of four one missing", bytes_of({0x27, 1, 2, 3}), 4, "has 4 data bytes, but only 3 follow"},
      {"collection left open", page + open, 4, "still open"},
      {"two collections left open by one", open + open + bytes_of({0xC0}), 5, "still open"},
      {"end without a collection", page + bytes_of({0xC0}), 2, "without a collection"},
      {"one end too many", open + bytes_of({0xC0, 0xC0}), 3, "one C0 too many"},
      {"range with its maximum below its minimum", bytes_of({0x15, 5, 0x25, 4, 0x81, 2}), 4, "5 to 4 is empty"},
      {"negative range upside down", bytes_of({0x15, 0xFE, 0x25, 0xFD, 0x81, 2}), 4, "-2 to -3 is empty"},
      {"report size 257", bytes_of({0x76, 1, 1}), 0, "report size 257: at most 256 bits"},
      {"report count 12289", bytes_of({0xA4, 0x96, 1, 0x30}), 1, "report count 12289: at most 12288"},
      {"report id 0", bytes_of({0x85, 0}), 0, "report id 0: 1 to 255"},
      {"report id 256", bytes_of({0x86, 0, 1}), 0, "report id 256: 1 to 255"},
      {"report id without data", bytes_of({0x84}), 0, "report id 0: 1 to 255"},
      {"five pushes", repeated({0xA4}, 5), 4, "at most 4 deep"},
      {"pop first", bytes_of({0xA4, 0xB4, 0xB4}), 2, "Pop without a Push"},
      {"unknown global item", bytes_of({0xC4}), 0, "unknown global item (tag 12)"},
      {"unknown global item 14", bytes_of({0xE5, 0}), 0, "unknown global item (tag 14)"},
      {"delimiter within a delimiter", bytes_of({0xA9, 1, 0xA9, 1}), 2, "within a delimiter"},
      {"close of no delimiter", bytes_of({0xA9, 0}), 0, "not open"},
      {"delimiter left open", bytes_of({0xA9, 1, 0x09, 1}), 4, "still open"},
      {"too long by one element", bytes_of({0x75, 8, 0x96, 0xFF, 0x2F, 0x81, 2, 0x96, 1, 0x10, 0x81, 2}), 10,
       "the most is 131064"},
      {"one report of 256 bits times 12288", bytes_of({0x76, 0, 1, 0x96, 0, 0x30, 0x81, 2}), 6, "3145728 bits"},
      {"range and one more usage", bytes_of({0x19, 0, 0x2A, 0xFF, 0x2F, 0x09, 1}), 5, "more than 12288 usages"},
      {"a range that passes 2^32", bytes_of({0x1B, 0xFE, 0xFF, 0xFF, 0xFF, 0x2B, 0xFF, 0xFF, 0xFF, 0xFF}), 5,
       "more than 12288 usages"},
      {"a range without room", bytes_of({0x1B, 0x01, 0xD0, 0xFF, 0xFF, 0x29, 1}), 5, "no room is left"},
  }};
  for (const Malformed& row : rows) {
    INFO(row.what);
    const auto result = parse_report_descriptor(row.bytes);
    REQUIRE_FALSE(result);
    CHECK(result.error().offset == row.offset);
    CHECK_THAT(result.error().message, Catch::Contains(row.message));
  }
}

TEST_CASE("one short of each limit is accepted") {
  CHECK(parsed(repeated({0xC3, 0, 0, 0, 0}, 0) + repeated({0xA4, 0xB4}, 2048)).fields.empty());  // 4096 bytes
  CHECK(parsed(bytes_of({0x76, 0, 1, 0x96, 0, 0x30})).fields.empty());                           // 256 bits, 12288 elements
  CHECK(parsed(repeated({0xA4}, 4)).fields.empty());
  CHECK(parsed(bytes_of({0x85, 1, 0x85, 255})).fields.empty());
  const ReportDescriptor longest = parsed(bytes_of({0x75, 8, 0x96, 0xFF, 0x2F, 0x81, 2, 0x96, 0, 0x10, 0x81, 2}));
  CHECK(longest.report(ReportType::input, 0)->bits == 131'064);
  const ReportDescriptor usages = parsed(bytes_of({0x75, 1, 0x95, 1, 0x19, 0, 0x2A, 0xFF, 0x2F, 0x81, 0}));
  CHECK(usages.fields.front().usages.size() == 12'288);
  // Collections nested as deep as the bytes allow. (The kernel's stack grows.)
  const ReportDescriptor deep = parsed(repeated({0xA0}, 2048) + repeated({0xC0}, 2048));
  CHECK((deep.collections.size() == 2048 && deep.collections.back().parent == 2046));
}

TEST_CASE("a maximum is unsigned where its minimum is not negative even if the minimum comes later") {
  const auto range = [](std::initializer_list<int> items) {
    Bytes bytes = bytes_of(items) + bytes_of({0x75, 32, 0x95, 1, 0x09, 1, 0x81, 2});
    const HidField field = parsed(bytes).fields.front();
    return std::pair(field.logical_minimum, field.logical_maximum);
  };
  using Range = std::pair<std::int64_t, std::int64_t>;
  CHECK(range({0x15, 0, 0x25, 0xFF}) == Range{0, 255});
  CHECK(range({0x15, 0xFF, 0x25, 0x7F}) == Range{-1, 127});
  CHECK(range({0x15, 0x80, 0x25, 0xFF}) == Range{-128, -1});
  CHECK(range({0x15, 0, 0x26, 0xA0, 0x8C}) == Range{0, 36'000});
  CHECK(range({0x15, 0, 0x27, 0xFF, 0xFF, 0xFF, 0xFF}) == Range{0, 2 * kTwo31 - 1});
  CHECK(range({0x15, 0xFF, 0x25, 0xFF, 0x15, 0}) == Range{0, 2 * kTwo31 - 1});
  CHECK(range({0x16, 0, 0x80, 0x26, 0xFF, 0x7F}) == Range{-32768, 32767});
}

TEST_CASE("a unit exponent is a nibble up to 15 and taken as it is otherwise") {
  for (int raw = -128; raw < 128; ++raw) {
    const ReportDescriptor descriptor = parsed_items({0x55, raw & 0xFF, 0x75, 8, 0x95, 1, 0x09, 0x30, 0x81, 2});
    CHECK(descriptor.fields.front().unit_exponent == (raw >= 8 && raw < 16 ? raw - 16 : raw));
  }
}

TEST_CASE("the last usage belongs to all further elements and usages beyond the count stay for arrays") {
  const ReportDescriptor few = parsed_items({0x75, 1, 0x95, 8, 0x09, 0x30, 0x09, 0x31, 0x81, 2});
  CHECK(usages_of(few.fields.front()) ==
        std::vector<std::uint32_t>{0x10030, 0x10031, 0x10031, 0x10031, 0x10031, 0x10031, 0x10031, 0x10031});
  CHECK(few.find(ReportType::input, 0, 0x10031)->index == 1);
  const ReportDescriptor many =
      parsed_items({0x75, 8, 0x95, 1, 0x19, 0x30, 0x29, 0x33, 0x81, 0, 0x19, 0x40, 0x29, 0x43, 0x81, 2});
  CHECK(usages_of(many.fields[0]) == std::vector<std::uint32_t>{0x10030, 0x10031, 0x10032, 0x10033});
  CHECK(many.find(ReportType::input, 0, 0x10033)->field == &many.fields[0]);  // an array may select it
  CHECK(many.find(ReportType::input, 0, 0x10040)->field == &many.fields[1]);
  CHECK_FALSE(many.find(ReportType::input, 0, 0x10041));  // a variable has one element, for its first usage
}

TEST_CASE("short usages take the page in force at their main item and long ones keep their own") {
  const ReportDescriptor descriptor = parsed_items(
      {0x75, 8, 0x95, 4, 0x09, 0x30, 0x0A, 0x31, 0x00, 0x0B, 0x22, 0, 0x0F, 0, 0x05, 0x02, 0x09, 0x32, 0x81, 2});
  // As Linux does, usages get the page from the last one backwards, until one is found that has that page already. The
  // usages before it keep page 1.
  CHECK(usages_of(descriptor.fields.front()) == std::vector<std::uint32_t>{0x10030, 0x10031, 0xF0022, 0x20032});
  const ReportDescriptor late =
      parsed_items({0x75, 8, 0x95, 3, 0x09, 0x30, 0x0B, 0x22, 0, 0x0F, 0, 0x09, 0x32, 0x05, 0x02, 0x81, 2});
  CHECK(usages_of(late.fields.front()) == std::vector<std::uint32_t>{0x20030, 0xF0022, 0x20032});
}

TEST_CASE("a usage range gives what its usages one by one would up to the ends of its page") {
  for (const int first : {0, 1, 0x2FFE, 0xD000, 0xFFF0}) {
    for (const int last : {first, first + 1, first + 15}) {
      Bytes range = bytes_of({0x05, 0x09, 0x75, 1, 0x95, 1}), single = range;
      add(range, kUsageMinimum, first, 4);
      add(range, kUsageMaximum, last, 2);
      for (int usage = first; usage <= last; ++usage) add(single, kUsage, usage, 2);
      for (Bytes* bytes : {&range, &single}) add(*bytes, kInput, 0, 1);
      CHECK(parsed(range).fields.front().usages == parsed(single).fields.front().usages);
    }
  }
  const auto usages = [](std::initializer_list<int> items) {
    return usages_of(
        parsed(bytes_of({0x05, 0x09, 0x75, 1, 0x95, 1}) + bytes_of(items) + bytes_of({0x81, 0})).fields.front());
  };
  // With four bytes a range continues beyond the end of its page.
  CHECK(usages({0x1B, 0xFF, 0xFF, 0, 0, 0x2B, 0, 0, 1, 0}) == std::vector<std::uint32_t>{0xFFFF, 0x10000});
  // The maximum has two bytes and is below the minimum, which has four. The result is as many usages as fit, from the lower
  // half of the minimum on, all of page 9.
  const auto cut = usages({0x1B, 0xFE, 0xFF, 1, 0, 0x2A, 1, 0});
  REQUIRE(cut.size() == 12'288);
  for (std::uint32_t i = 0; i < cut.size(); ++i) REQUIRE(cut[i] == (0x90000 | ((0xFFFE + i) & 0xFFFF)));
}

TEST_CASE("padding takes its bits and is no field and so is a 257th field of a report") {
  const ReportDescriptor padded = parsed_items({0x75, 3, 0x95, 1, 0x81, 3, 0x75, 5, 0x09, 0x30, 0x81, 2});
  REQUIRE(padded.fields.size() == 1);
  CHECK((padded.fields.front().bit_offset == 3 && padded.report(ReportType::input, 0)->bits == 8));
  const ReportDescriptor many =
      parsed(bytes_of({0x75, 1, 0x95, 1}) + repeated({0x09, 1, 0x81, 2}, 300) + bytes_of({0x09, 1, 0x91, 2}));
  CHECK((many.fields.size() == 257 && many.report(ReportType::input, 0)->bits == 300));
}

TEST_CASE("reserved items and unknown main and local ones and alternative usages are skipped") {
  const ReportDescriptor descriptor = parsed_items({0x0D, 9, 0x71, 3, 0x39, 4,    0x75, 8, 0x95, 2, 0xA9, 1, 0x09, 0x30,
                                                    0xA9, 0, 0xA9, 1, 0x09, 0x31, 0x19, 1, 0x29, 9, 0xA9, 0, 0x81, 2});
  // The unknown main item at the front did not end a collection. The second set of usages does not count.
  CHECK(usages_of(descriptor.fields.front()) == std::vector<std::uint32_t>{0x10030, 0x10030});
}

TEST_CASE("push and pop keep every global item") {
  const ReportDescriptor descriptor =
      parsed_items({0x85, 3,    0x15, 0xFF, 0x25, 1,    0x35, 2,    0x45, 9,    0x55, 2,    0x65, 0x11, 0x75, 8,
                    0x95, 2,    0xA4, 0x05, 9,    0x85, 4,    0x15, 0,    0x25, 9,    0x35, 0,    0x45, 0,    0x55,
                    0,    0x65, 0,    0x75, 4,    0x95, 1,    0x09, 1,    0x81, 2,    0xB4, 0x09, 0x30, 0x81, 6});
  REQUIRE(descriptor.fields.size() == 2);
  CHECK(static_cast<FieldLayout>(descriptor.fields[0]) == FieldLayout{ReportType::input, 4, 0, 4, 1, 2, 0, 9, 0, 0, 0, 0});
  CHECK(static_cast<FieldLayout>(descriptor.fields[1]) ==
        FieldLayout{ReportType::input, 3, 0, 8, 2, 6, -1, 1, 2, 9, 2, 0x11});
  CHECK((descriptor.fields[1].relative() && descriptor.fields[1].usages[0] == 0x10030));
}

TEST_CASE("a field knows the collections around it") {
  const ReportDescriptor descriptor =
      parsed_items({0x05, 0x0F, 0x09, 0x21, 0xA1, 2,    0x09, 0x57, 0xA1, 2,    0x75, 8, 0x95, 1,
                    0x0B, 1,    0,    0x0A, 0,    0x91, 2,    0xC0, 0x09, 0x50, 0x91, 2, 0xC0});
  REQUIRE(descriptor.fields.size() == 2);
  const std::vector<HidCollection> collections{{1, 0x10004, -1}, {2, 0xF0021, 0}, {2, 0xF0057, 1}};
  CHECK(descriptor.collections == collections);
  CHECK((descriptor.is_within(descriptor.fields[0], 0xF0057) && descriptor.is_within(descriptor.fields[0], 0xF0021)));
  CHECK_FALSE(descriptor.is_within(descriptor.fields[1], 0xF0057));
  CHECK((descriptor.enclosing(descriptor.fields[0], 2) == 0xF0057 &&
         descriptor.enclosing(descriptor.fields[0], 1) == 0x10004));
  CHECK(descriptor.enclosing(descriptor.fields[0], 0) == 0);
}

namespace {

/// A random valid descriptor, and what parsing it must give.
class Generator {
 public:
  explicit Generator(std::uint64_t seed) : random_(seed) {}

  Bytes bytes;
  ReportDescriptor expected;

  void build() {
    page(pick({0x01, 0x09, 0x0F, 0xFF00}));
    open();
    const int parts = 1 + below(12);
    for (int i = 0; i < parts; ++i) part();
    while (depth_ > 0) close();
  }

 private:
  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  int pick(std::initializer_list<int> values) { return *(values.begin() + below(static_cast<int>(values.size()))); }
  /// At least as many bytes as needed, sometimes more.
  int size_from(int needed) { return below(3) ? needed : pick({needed, needed == 1 ? 2 : 4, 4}); }
  void page(int value) {
    page_ = static_cast<std::uint32_t>(value);
    add(bytes, kUsagePage, value, size_from(unsigned_size(value)));
  }
  std::uint32_t usage_of(int id) const { return page_ << 16 | static_cast<std::uint32_t>(id); }

  void open() {
    const int usage = below(0x10000), type = below(7);
    add(bytes, kUsage, usage, unsigned_size(usage));
    add(bytes, kCollection, type, 1);
    expected.collections.push_back({static_cast<std::uint8_t>(type), usage_of(usage), at_});
    at_ = static_cast<std::int32_t>(expected.collections.size()) - 1;
    ++depth_;
  }
  void close() {
    add(bytes, kEndCollection, 0, 0);
    at_ = expected.collections[static_cast<std::size_t>(at_)].parent;
    --depth_;
  }

  void part() {
    switch (below(6)) {
      case 0:
        open();
        break;
      case 1:
        if (depth_ > 1) close();
        break;
      case 2:
        page(1 + below(0xFFFF));
        break;
      case 3:
        pushed_field();
        break;
      default:
        field();
        break;
    }
  }

  /// Globals that change between Push and Pop are as before afterwards.
  void pushed_field() {
    const auto kept = layout_;
    const std::uint32_t page_kept = page_;
    add(bytes, kPush, 0, 0);
    field();
    add(bytes, kPop, 0, 0);
    layout_ = kept;
    page_ = page_kept;
  }

  void set_range(int minimum_tag, int maximum_tag, std::int64_t& minimum, std::int64_t& maximum, std::int64_t largest) {
    minimum = below(2) ? 0 : -static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(largest));
    maximum = minimum + static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(largest));
    add(bytes, minimum_tag, minimum, size_from(signed_size(minimum)));
    // If the minimum is not negative, the maximum is unsigned. Otherwise it needs the room of a signed number.
    add(bytes, maximum_tag, maximum, size_from(minimum < 0 ? signed_size(maximum) : unsigned_size(maximum)));
  }

  void globals() {
    if (below(2)) {
      layout_.id = static_cast<std::uint8_t>(1 + below(255));
      add(bytes, kReportId, layout_.id, size_from(1));
    }
    if (below(2)) set_range(kLogicalMinimum, kLogicalMaximum, layout_.logical_minimum, layout_.logical_maximum, kTwo31 - 1);
    if (below(3) == 0)
      set_range(kPhysicalMinimum, kPhysicalMaximum, layout_.physical_minimum, layout_.physical_maximum, 100'000);
    if (below(3) == 0) {
      layout_.unit = static_cast<std::uint32_t>(random_());
      add(bytes, kUnit, layout_.unit, 4);
      layout_.unit_exponent = below(16) - 8;
      const bool nibble = below(2) != 0;
      add(bytes, kUnitExponent, nibble ? layout_.unit_exponent & 0xF : layout_.unit_exponent, 1);
    }
    if (below(2)) {
      layout_.bits = static_cast<std::uint32_t>(below(4) ? 1 + below(32) : below(257));
      add(bytes, kReportSize, layout_.bits, size_from(unsigned_size(layout_.bits)));
    }
    if (below(2)) {
      layout_.count = static_cast<std::uint32_t>(below(12));
      add(bytes, kReportCount, layout_.count, size_from(1));
    }
  }

  std::vector<std::uint32_t> usages() {
    std::vector<std::uint32_t> list;
    const int entries = below(4);
    for (int i = 0; i < entries; ++i) {
      const int first = below(0xFF00);
      switch (below(3)) {
        case 0:
          add(bytes, kUsage, first, size_from(unsigned_size(first)) == 1 ? 1 : 2);
          list.push_back(usage_of(first));
          break;
        case 1: {
          const auto extended = static_cast<std::uint32_t>(random_());
          add(bytes, kUsage, extended, 4);
          list.push_back(extended);
          break;
        }
        default: {
          const int last = first + below(9);
          add(bytes, kUsageMinimum, first, 2);
          add(bytes, kUsageMaximum, last, 2);
          for (int usage = first; usage <= last; ++usage) list.push_back(usage_of(usage));
        }
      }
    }
    return list;
  }

  void field() {
    globals();
    const std::vector<std::uint32_t> list = usages();
    layout_.type = static_cast<ReportType>(below(3));
    layout_.flags = static_cast<std::uint32_t>(below(0x200));
    add(bytes, std::array{kInput, kOutput, kFeature}[static_cast<std::size_t>(layout_.type)], layout_.flags, size_from(2));
    HidReport& report = report_of();
    HidField field;
    static_cast<FieldLayout&>(field) = layout_;
    field.bit_offset = report.bits;
    for (const std::uint32_t usage : list) field.usages.add(usage);
    field.collection = at_;
    report.bits += layout_.bits * layout_.count;
    if (list.empty()) return;
    expected.fields.push_back(field);
  }

  HidReport& report_of() {
    for (HidReport& report : expected.reports) {
      if (report.type == layout_.type && report.id == layout_.id) return report;
    }
    return expected.reports.emplace_back(HidReport{layout_.type, layout_.id, 0});
  }

  std::mt19937_64 random_;
  FieldLayout layout_;
  std::uint32_t page_ = 0;
  std::int32_t at_ = -1;
  int depth_ = 0;
};

}  // namespace

TEST_CASE("fifty thousand random valid descriptors say what they were built from") {
  std::size_t fields = 0, largest = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(50'000); ++seed) {
    Generator generator(seed);
    generator.build();
    const auto result = parse_report_descriptor(generator.bytes);
    INFO("seed " << seed);
    REQUIRE(result);
    REQUIRE(result->collections == generator.expected.collections);
    REQUIRE(result->reports == generator.expected.reports);
    REQUIRE(result->fields == generator.expected.fields);
    fields += generator.expected.fields.size();
    largest = std::max(largest, generator.bytes.size());
  }
  CHECK((fields > evenstep::testing::cases(100'000) && largest > 300));
}

TEST_CASE("a valid descriptor cut off anywhere after its first items is refused within what is left") {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Generator generator(seed);
    generator.build();
    for (std::size_t size = 0; size < generator.bytes.size(); ++size) {
      const auto result = parse_report_descriptor(std::span(generator.bytes).first(size));
      // The outermost collection is closed by the last byte. Only a prefix that ends before that collection is valid.
      if (result) REQUIRE((result->collections.empty() && size <= 10));
      if (!result) REQUIRE(result.error().offset <= size);
    }
  }
}

TEST_CASE("a million random byte strings are parsed or refused and no value of what was parsed traps") {
  std::mt19937_64 random(3);
  // In plain noise, items that fit together are too rare. So half of the bytes are prefixes that exist.
  const Bytes prefixes =
      bytes_of({0x05, 0x06, 0x09, 0x0A, 0x0B, 0x15, 0x16, 0x17, 0x19, 0x1A, 0x25, 0x26, 0x27, 0x29, 0x2A, 0x35,
                0x45, 0x55, 0x65, 0x75, 0x81, 0x85, 0x91, 0x95, 0xA1, 0xA4, 0xA9, 0xB1, 0xB4, 0xC0, 0xC0, 0xC0});
  int accepted = 0;
  for (int i = 0; i < evenstep::testing::cases(1'000'000); ++i) {
    std::array<std::byte, 24> bytes;
    const std::size_t size = random() % (bytes.size() + 1);
    for (std::byte& byte : bytes) {
      const std::uint64_t draw = random();
      byte = draw & 1 ? prefixes[draw >> 8 & 31] : static_cast<std::byte>(draw >> 8 & (draw & 2 ? 0x0F : 0xFF));
    }
    const auto result = parse_report_descriptor(std::span(bytes).first(size));
    if (!result) {
      if (result.error().offset > size || result.error().message.empty())
        FAIL("an error without a place or words at draw " << i);
      continue;
    }
    accepted += !result->fields.empty();
    std::array<std::byte, 64> report{};
    for (const HidField& field : result->fields) {
      REQUIRE(field.usages.size() >= 1);
      for (std::uint32_t index = 0; index < std::min<std::uint32_t>(field.count, 4); ++index) {
        if (const auto low = nearest(field, field.logical_minimum); low && set(report, field, index, *low))
          REQUIRE(get(report, field, index) == low);
      }
    }
  }
  CHECK(accepted > evenstep::testing::cases(5000));
}
