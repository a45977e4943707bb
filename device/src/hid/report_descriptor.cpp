#include "evenstep/device/hid/report_descriptor.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace evenstep {
namespace {

// Linux's limits (hid.h, 6.1).
constexpr std::size_t kMaxDescriptor = 4096;
constexpr std::uint32_t kMaxElementBits = 256;
constexpr std::uint32_t kMaxUsages = 12288;
constexpr std::uint32_t kMaxReportBits = (16384 - 1) * 8;
constexpr std::size_t kMaxFields = 256;
constexpr std::size_t kMaxPushed = 4;

enum ItemType : unsigned { kMain = 0, kGlobal = 1, kLocal = 2 };
constexpr unsigned kLongTag = 15;

struct Item {
  std::size_t offset = 0;
  unsigned type = 0, tag = 0, size = 0;
  std::uint32_t data = 0;
  std::int32_t signed_data() const {
    if (size == 1) return static_cast<std::int8_t>(data);
    if (size == 2) return static_cast<std::int16_t>(data);
    return static_cast<std::int32_t>(data);
  }
};

/// Global items keep their values until they are changed; Push saves all of them and Pop restores them.
struct Globals {
  std::uint32_t usage_page = 0, unit = 0, bits = 0, count = 0, id = 0;
  std::int32_t logical_minimum = 0, logical_maximum = 0, physical_minimum = 0, physical_maximum = 0, unit_exponent = 0;
};

/// A range of neighbouring usages on one page.
struct Usages {
  std::uint32_t first, count;
  bool has_page;
};

/// Local items, which apply to the next main item only.
struct Locals {
  std::vector<Usages> usages;
  std::uint32_t usage_count = 0, usage_minimum = 0;
  int alternatives = 0;
  bool in_delimiter = false;
};

/// A maximum is unsigned if its minimum is not negative.
std::int64_t maximum(std::int32_t minimum, std::int32_t raw_maximum) {
  return minimum < 0 ? std::int64_t{raw_maximum} : std::int64_t{static_cast<std::uint32_t>(raw_maximum)};
}

std::int32_t unit_exponent(std::int32_t raw) { return raw >= 8 && raw <= 15 ? raw - 16 : raw; }

/// Parses in one pass over the items. Each step returns what is wrong, or nothing.
class Parser {
 public:
  explicit Parser(std::span<const std::byte> bytes) : bytes_(bytes) {}
  Result<ReportDescriptor, DescriptorError> parse();

 private:
  using Refusal = std::optional<std::string>;
  std::optional<DescriptorError> fetch(Item& item);
  Refusal take(const Item& item);
  Refusal main(const Item& item);
  Refusal global(const Item& item);
  Refusal local(const Item& item);
  Refusal push();
  Refusal pop();
  Refusal delimiter(bool open);
  Refusal usage_range(std::uint32_t maximum, unsigned size);
  Refusal add_usages(std::uint32_t first, std::uint32_t count, unsigned size);
  Refusal add_field(ReportType type, std::uint32_t flags);
  HidField field_of(const HidReport& report, std::uint32_t bit_offset, std::uint32_t flags) const;
  void complete_usages();
  void open_collection(std::uint8_t type);
  HidReport& report_of(ReportType type);
  std::uint32_t with_page(std::uint32_t usage) const { return (globals_.usage_page & 0xFFFF) << 16 | (usage & 0xFFFF); }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  ReportDescriptor found_;
  Globals globals_;
  std::vector<Globals> pushed_;
  Locals locals_;
  std::int32_t open_ = -1;  // the innermost open collection
};

Result<ReportDescriptor, DescriptorError> Parser::parse() {
  const auto refuse = [](std::size_t offset, std::string message) {
    return Failure(DescriptorError{offset, std::move(message)});
  };
  if (bytes_.empty() || bytes_.size() > kMaxDescriptor)
    return refuse(0, fmt::format("a report descriptor has 1 to {} bytes, not {}", kMaxDescriptor, bytes_.size()));
  while (at_ < bytes_.size()) {
    Item item;
    if (auto error = fetch(item)) return Failure(*std::move(error));
    if (auto refusal = take(item)) return refuse(item.offset, *std::move(refusal));
  }
  if (open_ >= 0) return refuse(bytes_.size(), "a collection is still open: an End Collection (C0) is missing");
  if (locals_.in_delimiter) return refuse(bytes_.size(), "a delimiter is still open: its close (A9 00) is missing");
  return std::move(found_);
}

std::optional<DescriptorError> Parser::fetch(Item& item) {
  const auto prefix = std::to_integer<unsigned>(bytes_[at_]);
  item = {.offset = at_, .type = prefix >> 2 & 3, .tag = prefix >> 4, .size = (prefix & 3) == 3 ? 4 : prefix & 3};
  if (item.tag == kLongTag)
    return DescriptorError{at_, fmt::format("long item ({:02X}): only short items are supported", prefix)};
  ++at_;
  if (bytes_.size() - at_ < item.size) {
    return DescriptorError{bytes_.size(), fmt::format("the item at byte {} ({:02X}) has {} data bytes, but only {} follow",
                                                      item.offset, prefix, item.size, bytes_.size() - at_)};
  }
  for (unsigned i = 0; i < item.size; ++i) item.data |= std::to_integer<std::uint32_t>(bytes_[at_++]) << (8 * i);
  return std::nullopt;
}

Parser::Refusal Parser::take(const Item& item) {
  if (item.type == kMain) {
    complete_usages();
    auto refusal = main(item);
    locals_ = {};
    return refusal;
  }
  if (item.type == kGlobal) return global(item);
  if (item.type == kLocal) return local(item);
  return std::nullopt;
}

/// A usage page that comes after a usage of one or two bytes, but before the main item, applies to that usage too. As in
/// Linux, usages are completed from the last one backwards, up to the first one that has this page already.
void Parser::complete_usages() {
  for (auto usages = locals_.usages.rbegin(); usages != locals_.usages.rend(); ++usages) {
    if (usages->has_page) continue;
    if (usages->first >> 16 == globals_.usage_page) break;
    usages->first = with_page(usages->first);
  }
}

Parser::Refusal Parser::main(const Item& item) {
  switch (item.tag) {
    case 8:
      return add_field(ReportType::input, item.data);
    case 9:
      return add_field(ReportType::output, item.data);
    case 11:
      return add_field(ReportType::feature, item.data);
    case 10:
      open_collection(static_cast<std::uint8_t>(item.data));
      return std::nullopt;
    case 12:
      if (open_ < 0) return "End Collection without a collection: one C0 too many";
      open_ = found_.collections[static_cast<std::size_t>(open_)].parent;
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

void Parser::open_collection(std::uint8_t type) {
  found_.collections.push_back({type, locals_.usages.empty() ? 0 : locals_.usages.front().first, open_});
  open_ = static_cast<std::int32_t>(found_.collections.size()) - 1;
}

HidReport& Parser::report_of(ReportType type) {
  const auto id = static_cast<std::uint8_t>(globals_.id);
  for (HidReport& report : found_.reports) {
    if (report.type == type && report.id == id) return report;
  }
  return found_.reports.emplace_back(HidReport{type, id, 0});
}

Parser::Refusal Parser::add_field(ReportType type, std::uint32_t flags) {
  HidReport& report = report_of(type);
  if (maximum(globals_.logical_minimum, globals_.logical_maximum) < globals_.logical_minimum) {
    return fmt::format("the logical range {} to {} is empty: the maximum must not be below the minimum",
                       globals_.logical_minimum, globals_.logical_maximum);
  }
  const std::uint32_t offset = report.bits;
  report.bits += globals_.bits * globals_.count;  // at most 131,064 + 256 * 12,288
  if (report.bits > kMaxReportBits) {
    return fmt::format("report {} would have {} bits; the most is {}", report.id, report.bits, kMaxReportBits);
  }
  if (locals_.usages.empty()) return std::nullopt;
  const auto same_report = [&](const HidField& field) { return field.type == type && field.id == report.id; };
  if (std::count_if(found_.fields.begin(), found_.fields.end(), same_report) >= static_cast<std::ptrdiff_t>(kMaxFields)) {
    return std::nullopt;
  }
  found_.fields.push_back(field_of(report, offset, flags));
  return std::nullopt;
}

HidField Parser::field_of(const HidReport& report, std::uint32_t bit_offset, std::uint32_t flags) const {
  HidField field;
  field.type = report.type;
  field.id = report.id;
  field.bit_offset = bit_offset;
  field.bits = globals_.bits;
  field.count = globals_.count;
  field.flags = flags;
  field.logical_minimum = globals_.logical_minimum;
  field.logical_maximum = maximum(globals_.logical_minimum, globals_.logical_maximum);
  field.physical_minimum = globals_.physical_minimum;
  field.physical_maximum = maximum(globals_.physical_minimum, globals_.physical_maximum);
  field.unit_exponent = globals_.unit_exponent;
  field.unit = globals_.unit;
  for (const Usages& usages : locals_.usages) field.usages.add(usages.first, usages.count);
  field.collection = open_;
  return field;
}

Parser::Refusal Parser::global(const Item& item) {
  switch (item.tag) {
    case 0:
      globals_.usage_page = item.data;
      return std::nullopt;
    case 1:
      globals_.logical_minimum = item.signed_data();
      return std::nullopt;
    case 2:
      globals_.logical_maximum = globals_.logical_minimum < 0 ? item.signed_data() : static_cast<std::int32_t>(item.data);
      return std::nullopt;
    case 3:
      globals_.physical_minimum = item.signed_data();
      return std::nullopt;
    case 4:
      globals_.physical_maximum = globals_.physical_minimum < 0 ? item.signed_data() : static_cast<std::int32_t>(item.data);
      return std::nullopt;
    case 5:
      globals_.unit_exponent = unit_exponent(item.signed_data());
      return std::nullopt;
    case 6:
      globals_.unit = item.data;
      return std::nullopt;
    case 7:
      globals_.bits = item.data;
      if (item.data > kMaxElementBits) return fmt::format("report size {}: at most {} bits", item.data, kMaxElementBits);
      return std::nullopt;
    case 8:
      globals_.id = item.data;
      if (item.data < 1 || item.data > 255) return fmt::format("report id {}: 1 to 255 are possible", item.data);
      return std::nullopt;
    case 9:
      globals_.count = item.data;
      if (item.data > kMaxUsages) return fmt::format("report count {}: at most {}", item.data, kMaxUsages);
      return std::nullopt;
    case 10:
      return push();
    case 11:
      return pop();
    default:
      return fmt::format("unknown global item (tag {})", item.tag);
  }
}

Parser::Refusal Parser::push() {
  if (pushed_.size() == kMaxPushed) return fmt::format("Push without a Pop before it: at most {} deep", kMaxPushed);
  pushed_.push_back(globals_);
  return std::nullopt;
}

Parser::Refusal Parser::pop() {
  if (pushed_.empty()) return "Pop without a Push";
  globals_ = pushed_.back();
  pushed_.pop_back();
  return std::nullopt;
}

Parser::Refusal Parser::local(const Item& item) {
  if (item.tag == 10) return delimiter(item.data != 0);
  if (locals_.alternatives > 1) return std::nullopt;
  switch (item.tag) {
    case 0:
      return add_usages(item.data, 1, item.size);
    case 1:
      locals_.usage_minimum = item.data;
      return std::nullopt;
    case 2:
      return usage_range(item.data, item.size);
    default:
      return std::nullopt;
  }
}

Parser::Refusal Parser::delimiter(bool open) {
  if (open == locals_.in_delimiter)
    return open ? "a delimiter within a delimiter" : "the close of a delimiter that is not open";
  locals_.in_delimiter = open;
  if (open) ++locals_.alternatives;
  return std::nullopt;
}

/// In 32-bit arithmetic that wraps around, as in Linux: a range with too many usages is cut to those that fit, and so is a
/// range whose maximum lies below its minimum, although it has no usages. Linux counts until it is past the maximum; if that
/// is the largest number, it never gets there and runs out of room.
Parser::Refusal Parser::usage_range(std::uint32_t maximum, unsigned size) {
  const std::uint32_t minimum = locals_.usage_minimum, used = locals_.usage_count;
  if (maximum - minimum + used >= kMaxUsages) {
    maximum = kMaxUsages - used + minimum - 1;
    if (maximum == 0) return "a usage range that no room is left for";
  }
  if (maximum == UINT32_MAX) return add_usages(minimum, kMaxUsages + 1, size);
  return maximum < minimum ? std::nullopt : add_usages(minimum, maximum - minimum + 1, size);
}

/// A range of short usages that exceeds 0xFFFF continues at 0 of its page.
Parser::Refusal Parser::add_usages(std::uint32_t first, std::uint32_t count, unsigned size) {
  if (count > kMaxUsages - locals_.usage_count) return fmt::format("more than {} usages for one main item", kMaxUsages);
  locals_.usage_count += count;
  if (size == 4) {
    locals_.usages.push_back({first, count, true});
    return std::nullopt;
  }
  const std::uint32_t up_to_end = std::min(count, 0x10000 - (first & 0xFFFF));
  locals_.usages.push_back({with_page(first), up_to_end, false});
  if (up_to_end < count) locals_.usages.push_back({with_page(0), count - up_to_end, false});
  return std::nullopt;
}

}  // namespace

Result<ReportDescriptor, DescriptorError> parse_report_descriptor(std::span<const std::byte> bytes) {
  return Parser(bytes).parse();
}

void UsageList::add(std::uint32_t first, std::uint32_t count) {
  if (count == 0) return;
  const bool continues = !ranges_.empty() && first != 0 && first == ranges_.back().first + ranges_.back().count;
  if (continues)
    ranges_.back().count += count;
  else
    ranges_.push_back({first, count});
}

std::uint32_t UsageList::size() const {
  std::uint32_t size = 0;
  for (const Range& range : ranges_) size += range.count;
  return size;
}

std::uint32_t UsageList::operator[](std::uint32_t index) const {
  for (const Range& range : ranges_) {
    if (index < range.count) return range.first + index;
    index -= range.count;
  }
  return ranges_.back().first + ranges_.back().count - 1;
}

std::optional<std::uint32_t> UsageList::find(std::uint32_t usage, std::uint32_t limit) const {
  std::uint32_t before = 0;
  for (const Range& range : ranges_) {
    const std::uint32_t place = usage - range.first;
    if (place < range.count) return before + place < limit ? std::optional(before + place) : std::nullopt;
    before += range.count;
  }
  return std::nullopt;
}

const HidReport* ReportDescriptor::report(ReportType type, std::uint8_t id) const {
  for (const HidReport& candidate : reports) {
    if (candidate.type == type && candidate.id == id) return &candidate;
  }
  return nullptr;
}

std::optional<HidElement> ReportDescriptor::find(ReportType type, std::uint8_t id, std::uint32_t usage) const {
  for (const HidField& field : fields) {
    if (field.type != type || field.id != id || field.count == 0) continue;
    const auto place = field.usages.find(usage, field.variable() ? field.count : UINT32_MAX);
    if (place) return HidElement{&field, field.variable() ? *place : 0};
  }
  return std::nullopt;
}

bool ReportDescriptor::is_within(const HidField& field, std::uint32_t collection_usage) const {
  for (std::int32_t at = field.collection; at >= 0; at = collections[static_cast<std::size_t>(at)].parent) {
    if (collections[static_cast<std::size_t>(at)].usage == collection_usage) return true;
  }
  return false;
}

std::uint32_t ReportDescriptor::enclosing(const HidField& field, std::uint8_t collection_type) const {
  for (std::int32_t at = field.collection; at >= 0; at = collections[static_cast<std::size_t>(at)].parent) {
    const HidCollection& around = collections[static_cast<std::size_t>(at)];
    if (around.type == collection_type) return around.usage;
  }
  return 0;
}

}  // namespace evenstep
