#include "evenstep/format/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

namespace evenstep::internal {

const Value* Value::find(std::string_view key) const {
  for (const Entry& entry : table) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

Value* Value::find(std::string_view key) {
  for (Entry& entry : table) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

Value text_value(std::string text, Place place) {
  Value value;
  value.kind = Value::Kind::text;
  value.text = std::move(text);
  value.place = std::move(place);
  return value;
}

Value integer_value(std::int64_t integer, Place place) {
  Value value;
  value.kind = Value::Kind::integer;
  value.integer = integer;
  value.place = std::move(place);
  return value;
}

std::string_view name_of(Value::Kind kind) {
  switch (kind) {
    case Value::Kind::boolean:
      return "true or false";
    case Value::Kind::integer:
      return "a whole number";
    case Value::Kind::number:
      return "a number";
    case Value::Kind::text:
      return "a string";
    case Value::Kind::list:
      return "a list";
    case Value::Kind::table:
      return "a table";
    case Value::Kind::date:
      return "a date or time of day";
  }
  return "";
}

std::string as_written(const Value& value) {
  switch (value.kind) {
    case Value::Kind::boolean:
      return value.boolean ? "true" : "false";
    case Value::Kind::integer:
      return std::to_string(value.integer);
    case Value::Kind::number:
      return fmt::format("{}", value.number);
    case Value::Kind::text:
      return fmt::format("\"{}\"", value.text);
    default:
      return std::string(name_of(value.kind));
  }
}

void Errors::add(const Place& place, std::string message) {
  if (count_++ < kMostErrors) list_.push_back({place.file, place.line, place.column, std::move(message)});
}

void Errors::note(const Place& place, std::string message) {
  Diagnostic note{place.file, place.line, place.column, std::move(message)};
  if (notes_.size() < kMostErrors && std::find(notes_.begin(), notes_.end(), note) == notes_.end())
    notes_.push_back(std::move(note));
}

std::vector<Diagnostic> Errors::sorted(const std::string& first_file) const {
  std::vector<Diagnostic> out = list_;
  std::stable_sort(out.begin(), out.end(), [&](const Diagnostic& a, const Diagnostic& b) {
    const bool a_later = a.file != first_file, b_later = b.file != first_file;
    return std::tie(a_later, a.file, a.line, a.column) < std::tie(b_later, b.file, b.line, b.column);
  });
  if (count_ > list_.size()) {
    const Diagnostic& last = out.back();
    out.push_back({last.file, last.line, last.column, fmt::format("{} more errors are not listed", count_ - list_.size())});
  }
  return out;
}

}  // namespace evenstep::internal
