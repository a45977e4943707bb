#pragma once
/// Checks the tables of a file against the field table. First everything is checked; then values are read by typed getters
/// that cannot fail.

#include <glm/vec3.hpp>
#include <set>
#include <string>
#include <vector>

#include "evenstep/format/document.h"
#include "evenstep/format/fields.h"
#include "evenstep/format/scenario.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

/// Checks a whole document for unknown and missing keys, forms, units and ranges. Rules about several keys are checked
/// later.
class Check {
 public:
  Check(const Value& document, Errors& errors);
  /// Whether no error was found in this table (or list) or below it.
  bool sound(const Value* value) const { return faulty_.count(value) == 0; }

 private:
  void table(const std::string& name, const Value& value);
  void entry(const std::string& name, const Value& table, const Entry& entry);
  void value(const Field& field, const Value& value);
  void element(const Field& field, const Value& value);
  void missing(const std::string& name, const Value& value);

  Errors& errors_;
  std::set<const Value*> faulty_;
};

/// "pareto 3 ms cap 40 ms"
struct ParetoText {
  Duration least, most;
};

/// "lognormal 10 %" or "uniform 10 %"
struct JitterText {
  JitterLaw law = JitterLaw::log_normal;
  double variation = 0;
};

/// "11.1 ms", "render", "render 11.1 ms" or "burn 11.1 ms"
struct WorkText {
  VisualizationWork work = VisualizationWork::pause;
  std::optional<Duration> length;  ///< empty: not known beforehand
};

/// A table without errors, read key by key; a key that is not there has its default.
class Table {
 public:
  /// If `value` is nullptr, every key has its default.
  Table(const Value* value, std::string name, Place around)
      : value_(value), name_(std::move(name)), around_(std::move(around)) {}

  bool has(std::string_view key) const { return value_ != nullptr && value_->find(key) != nullptr; }
  const std::string& name() const { return name_; }
  /// Whether there is such a key for the kind of this table.
  bool exists(std::string_view key) const;
  /// The place of the key's value, or that of the table if the key is not there.
  Place place(std::string_view key) const;
  /// The given value or the default; asking for a key that has neither is a programming error.
  Value at(std::string_view key) const;
  Table table(std::string_view key) const;

  std::string text(std::string_view key) const { return at(key).text; }
  std::int64_t integer(std::string_view key) const { return at(key).integer; }
  bool boolean(std::string_view key) const { return at(key).boolean; }
  double number(std::string_view key) const;
  double si(std::string_view key) const;
  glm::dvec3 vector(std::string_view key) const;
  Rate rate(std::string_view key) const { return *parse_rate(text(key)); }
  /// For a field of the form kDuration.
  Duration duration(std::string_view key) const { return *parse_duration(text(key)); }
  /// For a field of the form kSpan. Adds an error if the nominal unit makes it too long. If the nominal times are not known,
  /// [timing] has an error already.
  Duration span(std::string_view key, const NominalUnits& nominal, Errors& errors) const;
  /// A ratio in millionths. Adds an error if that is no whole number.
  std::int64_t whole_ppm(std::string_view key, Errors& errors) const;
  JitterText jitter(std::string_view key) const;
  Duration smooth(std::string_view key) const;
  WorkText work(std::string_view key) const;
  ParetoText pareto(std::string_view key) const;
  double segments(std::string_view key) const;  ///< for a field of the form kSegments
  std::vector<Table> tables(std::string_view key) const;

 private:
  const Field& field(std::string_view key) const;

  const Value* value_;
  std::string name_;
  Place around_;
};

}  // namespace evenstep::internal
