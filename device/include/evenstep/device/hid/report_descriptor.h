#pragma once
/// A HID device's description of its reports (HID 1.11, section 6.2.2): parses a report descriptor into fields, and reads
/// and writes the values in the bits of a report. This is our own code, because no library of the distribution does it.
///
/// It accepts and refuses exactly what Linux's hid-core (6.1) does, so the fields here are those of the kernel's own dump
/// (debugfs `rdesc`, which shows a maximum above 2^31 - 1 as negative). Where this is not what one would expect from the
/// standard:
///   - Long items are refused, wherever they are. Reserved items, unknown main items and unknown local items are skipped.
///   - A maximum is unsigned if its minimum is not negative: `15 00 27 FF FF FF FF` is 0 to 2^32 - 1.
///   - A unit exponent of 0 to 15 is a 4-bit two's complement number; any other value is taken as it is.
///   - A usage of one or two bytes is on the usage page in force at its main item; one of four bytes names its own page.
///   - The last usage applies to all further elements. Usages beyond the count are kept (arrays select from them).
///   - A field without a usage is padding: it takes up its bits but is not listed. The same holds for the 257th field of a
///     report.
///   - Of alternative usages (delimiters) only the first set counts. Collections may be nested to any depth.
///   - Fields outside any collection, and reports without an id in addition to numbered ones, are accepted.
///   - Push and Pop keep the range, unit, size, count and id together, four deep.
/// Limits: descriptor 1 to 4096 bytes, field element 256 bits, count 12288, usages of a field 12288, id 1 to 255, report
/// 16383 bytes without its id. Usages are kept as ranges, so the result is at most a few times larger than the descriptor.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/time/result.h"

namespace evenstep {

enum class ReportType : std::uint8_t { input, output, feature };

/// Where the elements of a field lie and what they may contain: all that is needed to get and set values.
struct FieldLayout {
  ReportType type = ReportType::input;
  std::uint8_t id = 0;               ///< of the report; 0: not numbered
  std::uint32_t bit_offset = 0;      ///< of element 0, from the first bit after the id
  std::uint32_t bits = 0;            ///< of one element; its first bit is the lowest
  std::uint32_t count = 0;           ///< number of elements, one after the other
  std::uint32_t flags = 0;           ///< the main item's data; see below
  std::int64_t logical_minimum = 0;  ///< negative: the element is signed (two's complement)
  std::int64_t logical_maximum = 0;
  std::int64_t physical_minimum = 0;  ///< minimum and maximum both 0: the same as the logical range
  std::int64_t physical_maximum = 0;
  std::int32_t unit_exponent = 0;
  std::uint32_t unit = 0;  ///< nibbles, as declared; the third is the power of time

  bool constant() const { return flags & 0x01; }
  bool variable() const { return flags & 0x02; }  ///< otherwise an array: each element selects a usage
  bool relative() const { return flags & 0x04; }
  bool has_null() const { return flags & 0x40; }  ///< values outside the logical range mean "no value"
  /// Bytes before the first field: the id, or the 0 that the transport expects in its place (hid_transport.h).
  std::size_t id_bytes() const { return id == 0 && type == ReportType::input ? 0 : 1; }
  friend bool operator==(const FieldLayout&, const FieldLayout&) = default;
};

struct HidCollection {
  std::uint8_t type = 0;     ///< 0 physical, 1 application, 2 logical, ...
  std::uint32_t usage = 0;   ///< page in the upper 16 bits
  std::int32_t parent = -1;  ///< index of the collection around it, -1: none
  friend bool operator==(const HidCollection&, const HidCollection&) = default;
};

/// A list of usages in declared order; consecutive usages are stored as ranges. The list of a field is never empty, and its
/// last usage applies to all further elements.
class UsageList {
 public:
  void add(std::uint32_t first, std::uint32_t count = 1);
  /// The number of usages declared.
  std::uint32_t size() const;
  /// For an index past the end, the last usage.
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
  UsageList usages;              ///< of a variable field: one per element; of an array: those it selects from
  std::int32_t collection = -1;  ///< the innermost one around it
  friend bool operator==(const HidField&, const HidField&) = default;
};

struct HidReport {
  ReportType type = ReportType::input;
  std::uint8_t id = 0;
  std::uint32_t bits = 0;  ///< of all fields and padding, without the id
  /// Number of bytes as read from or written to a transport.
  std::size_t size() const { return (bits + 7) / 8 + (id == 0 && type == ReportType::input ? 0 : 1); }
  friend bool operator==(const HidReport&, const HidReport&) = default;
};

/// One element of a field.
struct HidElement {
  const HidField* field = nullptr;  ///< in the descriptor that was searched
  std::uint32_t index = 0;
};

struct ReportDescriptor {
  std::vector<HidCollection> collections;  ///< in the order of opening
  std::vector<HidReport> reports;          ///< in the order of their first main item
  std::vector<HidField> fields;            ///< in the order of declaration

  /// nullptr if there is no such report.
  const HidReport* report(ReportType type, std::uint8_t id) const;
  /// The first element with this usage in that report. If an array selects from this usage: the first element of the array.
  std::optional<HidElement> find(ReportType type, std::uint8_t id, std::uint32_t usage) const;
  /// Whether one of the collections around the field has this usage.
  bool is_within(const HidField& field, std::uint32_t collection_usage) const;
  /// The usage of the innermost collection of that type around the field; 0 if there is none.
  std::uint32_t enclosing(const HidField& field, std::uint8_t collection_type) const;
};

struct DescriptorError {
  std::size_t offset = 0;  ///< byte at which the refused item begins; the descriptor's size if bytes are missing
  std::string message;
};

Result<ReportDescriptor, DescriptorError> parse_report_descriptor(std::span<const std::byte> bytes);

/// Element `index` of a report as the transport delivers it. Empty if there is no such element, if it has 0 or more than 32
/// bits, or if the report is too short. The value is what the device sent, so it may be outside the logical range.
std::optional<std::int64_t> get(std::span<const std::byte> report, const FieldLayout& field, std::uint32_t index = 0);
/// Returns false and writes nothing if `get` would be empty or if the field cannot hold the value (see can_hold).
bool set(std::span<std::byte> report, const FieldLayout& field, std::uint32_t index, std::int64_t value);
/// Sets the bits of the element whatever the logical range is: for values that are outside of it by convention.
bool set_raw(std::span<std::byte> report, const FieldLayout& field, std::uint32_t index, std::uint32_t bits);
/// Whether the value is in the logical range and can be represented in the bits of the element.
bool can_hold(const FieldLayout& field, std::int64_t value);
/// The nearest value that the field can hold; empty if it can hold none.
std::optional<std::int64_t> nearest(const FieldLayout& field, std::int64_t value);

/// The value with which an element of an array selects `usage`: logical_minimum + the place of the usage in the list. Empty
/// if the usage is not in the list or the field cannot hold the value.
std::optional<std::int64_t> selector(const HidField& array, std::uint32_t usage);
/// The usage that a value selects; empty if it selects nothing.
std::optional<std::uint32_t> selected(const HidField& array, std::int64_t value);

/// (logical - logical_minimum) (P_max - P_min) / (logical_maximum - logical_minimum) + P_min, times 10^exponent, in the
/// field's unit (HID's linear units: cm, g, s). P is the physical range; it is the logical range if both ends of the
/// physical one are 0 or if either range is empty.
double to_physical(const FieldLayout& field, std::int64_t logical);
/// The nearest logical value that the field can hold, halves away from zero. Empty for a value that is not finite.
std::optional<std::int64_t> to_logical(const FieldLayout& field, double physical);

}  // namespace evenstep
