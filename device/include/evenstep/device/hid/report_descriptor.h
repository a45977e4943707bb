#pragma once
/// What a HID device says about its reports (HID 1.11, section 6.2.2): its report descriptor, parsed into fields, and the
/// values in a report's bits. Own code, since no library of the distribution does it.
///
/// Accepts and refuses exactly what Linux's hid-core (6.1) does, so that a field here is a field of the kernel's own dump
/// (debugfs `rdesc`, which shows a maximum above 2^31 - 1 as negative). Where that is not what one would expect of the
/// standard:
///   - Long items are refused, wherever they are. Reserved items, unknown main items and unknown local items are skipped.
///   - A maximum is unsigned where its minimum is not negative: `15 00 27 FF FF FF FF` is 0 to 2^32 - 1.
///   - A unit exponent of 0 to 15 is a 4-bit two's complement number; any other value is taken as it is.
///   - A usage of one or two bytes gets the usage page in force at its main item, one of four bytes has its own.
///   - The last usage is that of all further elements. Usages beyond the count are kept (arrays select from them).
///   - A field without a usage is padding: it takes up its bits and is no field. So is a 257th field of a report.
///   - Of alternative usages (delimiters) only the first set counts. Collections may be nested to any depth.
///   - Fields in no collection, and reports without an id beside numbered ones, are accepted.
///   - Push and Pop keep the range, unit, size, count and id together, four deep.
/// Limits: descriptor 1 to 4096 bytes, field element 256 bits, count 12288, usages of a field 12288, id 1 to 255, report
/// 16383 bytes besides its id. Usages are kept as ranges, so that the result is no larger than a few times the descriptor.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/time/result.h"

namespace evenstep {

enum class ReportType : std::uint8_t { input, output, feature };

/// Where a field's elements lie, and what they may hold. All that getting and setting a value needs.
struct FieldLayout {
  ReportType type = ReportType::input;
  std::uint8_t id = 0;               ///< of the report; 0: not numbered
  std::uint32_t bit_offset = 0;      ///< of element 0, from the first bit after the id
  std::uint32_t bits = 0;            ///< of one element; the first bit is the lowest
  std::uint32_t count = 0;           ///< elements, one after the other
  std::uint32_t flags = 0;           ///< the main item's data; see below
  std::int64_t logical_minimum = 0;  ///< negative: the element is signed (two's complement)
  std::int64_t logical_maximum = 0;
  std::int64_t physical_minimum = 0;  ///< both 0: as the logical range
  std::int64_t physical_maximum = 0;
  std::int32_t unit_exponent = 0;
  std::uint32_t unit = 0;  ///< nibbles, as declared; the third is the power of time

  bool constant() const { return flags & 0x01; }
  bool variable() const { return flags & 0x02; }  ///< otherwise an array: each element selects a usage
  bool relative() const { return flags & 0x04; }
  bool has_null() const { return flags & 0x40; }  ///< values outside the logical range mean "no value"
  /// Bytes before the first field: the id, or the 0 that the transport wants in its place (hid_transport.h).
  std::size_t id_bytes() const { return id == 0 && type == ReportType::input ? 0 : 1; }
  friend bool operator==(const FieldLayout&, const FieldLayout&) = default;
};

struct HidCollection {
  std::uint8_t type = 0;     ///< 0 physical, 1 application, 2 logical, ...
  std::uint32_t usage = 0;   ///< page in the upper 16 bits
  std::int32_t parent = -1;  ///< index of the collection around it, -1: none
  friend bool operator==(const HidCollection&, const HidCollection&) = default;
};

/// Usages in their order, neighbours as ranges. Never empty in a field; the last belongs to all that follows.
class UsageList {
 public:
  void add(std::uint32_t first, std::uint32_t count = 1);
  /// As many as declared.
  std::uint32_t size() const;
  /// The last one's for an index past the end.
  std::uint32_t operator[](std::uint32_t index) const;
  /// The first place of a usage, within the first `limit` places.
  std::optional<std::uint32_t> find(std::uint32_t usage, std::uint32_t limit = UINT32_MAX) const;
  friend bool operator==(const UsageList&, const UsageList&) = default;

 private:
  struct Range {
    std::uint32_t first, count;
    friend bool operator==(const Range&, const Range&) = default;
  };
  std::vector<Range> ranges_;
};

struct HidField : FieldLayout {
  UsageList usages;              ///< usages[i]: of element i in a variable field; what an array selects from
  std::int32_t collection = -1;  ///< the innermost around it
  friend bool operator==(const HidField&, const HidField&) = default;
};

struct HidReport {
  ReportType type = ReportType::input;
  std::uint8_t id = 0;
  std::uint32_t bits = 0;  ///< of all fields and padding, without the id
  /// Bytes as read from or written to a transport.
  std::size_t size() const { return (bits + 7) / 8 + (id == 0 && type == ReportType::input ? 0 : 1); }
  friend bool operator==(const HidReport&, const HidReport&) = default;
};

/// One element of a field.
struct HidElement {
  const HidField* field = nullptr;  ///< in the descriptor that was asked
  std::uint32_t index = 0;
};

struct ReportDescriptor {
  std::vector<HidCollection> collections;  ///< in the order of opening
  std::vector<HidReport> reports;          ///< in the order of their first main item
  std::vector<HidField> fields;            ///< in the order of declaration

  /// nullptr: there is no such report.
  const HidReport* report(ReportType type, std::uint8_t id) const;
  /// The first element with this usage in that report; of an array's usages, the array's first element.
  std::optional<HidElement> find(ReportType type, std::uint8_t id, std::uint32_t usage) const;
  /// Whether one of the collections around the field has this usage.
  bool is_within(const HidField& field, std::uint32_t collection_usage) const;
  /// Usage of the innermost collection of that type around the field; 0: none.
  std::uint32_t enclosing(const HidField& field, std::uint8_t collection_type) const;
};

struct DescriptorError {
  std::size_t offset = 0;  ///< byte at which the refused item begins; the size where bytes are missing
  std::string message;
};

Result<ReportDescriptor, DescriptorError> parse_report_descriptor(std::span<const std::byte> bytes);

/// Element `index` of a report as a transport gives it. None: no such element, an element of 0 or of more than 32 bits, or a
/// report too short to hold it. The value may be outside the logical range: the device said so.
std::optional<std::int64_t> get(std::span<const std::byte> report, const FieldLayout& field, std::uint32_t index = 0);
/// False, and nothing is written, where get would give none or the value is not one that `can_hold`.
bool set(std::span<std::byte> report, const FieldLayout& field, std::uint32_t index, std::int64_t value);
/// The element's lowest bits, whatever the logical range says: for values that a convention puts outside it.
bool set_raw(std::span<std::byte> report, const FieldLayout& field, std::uint32_t index, std::uint32_t bits);
/// In the logical range, and in what the element's bits can represent.
bool can_hold(const FieldLayout& field, std::int64_t value);
/// The nearest value to it that the field can hold; none where there is none.
std::optional<std::int64_t> nearest(const FieldLayout& field, std::int64_t value);

/// An array's element that selects `usage` holds logical_minimum + its place in the list. None: not in the list, or out of
/// what the field can hold.
std::optional<std::int64_t> selector(const HidField& array, std::uint32_t usage);
/// What a value selects; none: nothing.
std::optional<std::uint32_t> selected(const HidField& array, std::int64_t value);

/// (logical - logical_minimum) (P_max - P_min) / (logical_maximum - logical_minimum) + P_min, times 10^exponent, in the
/// field's unit (HID's linear units: cm, g, s). P the physical range, or the logical one where both its ends are 0, and
/// where a range is empty.
double to_physical(const FieldLayout& field, std::int64_t logical);
/// The nearest logical value, halves away from zero, that the field can hold. None for what is not finite.
std::optional<std::int64_t> to_logical(const FieldLayout& field, double physical);

}  // namespace evenstep
