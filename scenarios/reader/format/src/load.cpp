#include "evenstep/format/load.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string_view>

#include "evenstep/text/text_file.h"

namespace evenstep::internal {
namespace {

bool holds_tables(const Value& value) {
  return value.is(Value::Kind::list) && !value.list.empty() && value.list.front().is(Value::Kind::table);
}

/// Merges tables and notes what is lost without anyone having said so.
class Merging {
 public:
  /// `before`: the files of the bases in the same list of `extends` that were merged before.
  Merging(std::vector<std::string> before, Errors& errors) : before_(std::move(before)), errors_(errors) {}

  /// Merges `over` into `base`. Values and places of `over` are used, so that an error points at the line that counts.
  void merge(Value& base, Value over, std::string_view key = "") {
    if (!base.is(Value::Kind::table) || !over.is(Value::Kind::table)) {
      note_loss(base, over, key);
      base = std::move(over);
      return;
    }
    base.place = over.place;
    for (Entry& entry : over.table) {
      const auto same =
          std::find_if(base.table.begin(), base.table.end(), [&](const Entry& e) { return e.key == entry.key; });
      if (same == base.table.end()) {
        base.table.push_back(std::move(entry));
      } else {
        same->place = entry.place;
        merge(same->value, std::move(entry.value), entry.key);
      }
    }
  }

 private:
  /// A list such as [[device]] is written like an addition. A file that comes in once more, as the base of another file,
  /// takes back what a file before that one has changed. What only comes in twice is no loss.
  void note_loss(const Value& lost, const Value& by, std::string_view key) {
    if (key.empty() || lost.place == by.place) return;
    const bool again = std::find(before_.begin(), before_.end(), by.place.file) != before_.end();
    if (!holds_tables(lost) && !again) return;
    errors_.note(by.place,
                 fmt::format("'{}' replaces {} at {}:{}:{}, because {}{}", key,
                             lost.is(Value::Kind::list) ? fmt::format("the list of {}", lost.list.size()) : as_written(lost),
                             lost.place.file, lost.place.line, lost.place.column,
                             again ? "this file comes in once more after that one" : "lists are not joined",
                             key == "expect" ? "; [[expect_append]] would add to it" : ""));
  }

  std::vector<std::string> before_;
  Errors& errors_;
};

/// Takes a key out of a table that has it.
Value take(Value& table, std::string_view key) {
  const auto found = std::find_if(table.table.begin(), table.table.end(), [&](const Entry& e) { return e.key == key; });
  Value value = std::move(found->value);
  table.table.erase(found);
  return value;
}

/// Moves expect_append of `document` to the end of `all`. What comes in twice, because two files extend the same one, is
/// there once.
void collect_appended(Value& document, std::vector<Value>& all, Errors& errors) {
  if (document.find("expect_append") == nullptr) return;
  Value more = take(document, "expect_append");
  if (!more.is(Value::Kind::list)) {
    errors.add(more.place, "'expect_append' must be a list of tables; write [[expect_append]]");
    return;
  }
  for (Value& expectation : more.list) {
    const bool known = std::any_of(all.begin(), all.end(), [&](const Value& one) { return one.place == expectation.place; });
    if (!known) all.push_back(std::move(expectation));
  }
}

/// Whether the file has a known format. In a later format the same keys may have another meaning, so nothing else in such a
/// file is checked.
bool format_is_known(const Value& document, const std::string& path, Errors& errors) {
  const Value* format = document.find("format");
  if (format == nullptr) {
    errors.add({path, 1, 1}, fmt::format("no 'format'; write format = {} at the top", kScenarioFormat));
    return false;
  }
  if (!format->is(Value::Kind::integer) || format->integer != kScenarioFormat) {
    errors.add(format->place, fmt::format("format = {} is not known to this version, which reads format = {}",
                                          as_written(*format), kScenarioFormat));
    return false;
  }
  return true;
}

std::string same_file_key(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(path, ignored).string();
}

/// Loads a file with those that it extends.
class Loading {
 public:
  explicit Loading(Errors& errors) : errors_(errors) {}

  /// Of all files, without expect_append. `named_at`: where the file is named.
  Value load(const std::string& path, const Place& named_at) {
    const Step step{path, same_file_key(path)};
    const auto same = std::find_if(chain_.begin(), chain_.end(), [&](const Step& s) { return s.key == step.key; });
    if (same != chain_.end()) {
      std::string names;
      for (auto s = same; s != chain_.end(); ++s) names += s->path + " -> ";
      errors_.add(named_at, fmt::format("'extends' goes in a circle: {}{}", names, path));
      return {};
    }
    if (chain_.size() >= kMostExtendsDepth) {
      errors_.add(named_at, fmt::format("'extends' is deeper than {} files", kMostExtendsDepth));
      return {};
    }
    const Result<std::string> file = read_text_file(path, kMostScenarioBytes);
    if (!file) {
      errors_.add(named_at, named_at.line == 0 ? file.error() : fmt::format("'{}' {}", path, file.error()));
      return {};
    }
    const std::size_t errors_before = errors_.count();
    Value document = parse_toml(*file, path, errors_);
    if (errors_.count() > errors_before || !format_is_known(document, path, errors_)) return {};

    chain_.push_back(step);
    Value merged = load_bases(document);
    chain_.pop_back();
    collect_appended(document, appended_, errors_);
    Merging({}, errors_).merge(merged, std::move(document));
    loaded_.push_back(path);
    return merged;
  }

  /// expect_append of all files that were loaded, in their order. No file can remove what another one has added.
  std::vector<Value> take_appended() { return std::move(appended_); }

 private:
  struct Step {
    std::string path, key;
  };

  /// Merges the base files of `document`, and removes `extends` from it.
  Value load_bases(Value& document) {
    Value merged;
    if (document.find("extends") == nullptr) return merged;
    const Value extends = take(document, "extends");
    const bool texts = extends.is(Value::Kind::list) && std::all_of(extends.list.begin(), extends.list.end(),
                                                                    [](const Value& v) { return v.is(Value::Kind::text); });
    if (!texts) {
      errors_.add(extends.place, "'extends' must be a list of files, such as [\"base.toml\"]");
      return merged;
    }
    const std::size_t first = loaded_.size();
    for (const Value& base : extends.list) {
      Merging merging(std::vector(loaded_.begin() + static_cast<std::ptrdiff_t>(first), loaded_.end()), errors_);
      merging.merge(merged, load(path_from(base), base.place));
    }
    return merged;
  }

  Errors& errors_;
  std::vector<Step> chain_;
  std::vector<std::string> loaded_;
  std::vector<Value> appended_;
};

}  // namespace

Value load_document(const std::string& path, Errors& errors) {
  Loading loading(errors);
  Value document = loading.load(path, {path, 0, 0});
  std::vector<Value> appended = loading.take_appended();
  if (appended.empty()) return document;
  Value* expect = document.find("expect");
  if (expect == nullptr) {
    Value list;
    list.kind = Value::Kind::list;
    list.place = appended.front().place;
    document.table.push_back({"expect", list.place, std::move(list)});
    expect = &document.table.back().value;
  }
  std::move(appended.begin(), appended.end(), std::back_inserter(expect->list));
  return document;
}

std::string path_from(const Value& path) {
  namespace fs = std::filesystem;
  if (path.place.line == 0) return path.text;  // written on the command line
  return (fs::path(path.place.file).parent_path() / path.text).lexically_normal().string();
}

}  // namespace evenstep::internal
