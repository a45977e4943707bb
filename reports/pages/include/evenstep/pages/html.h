#pragma once
/// HTML that is put together from text and elements. Text is escaped wherever it is made into Html, so that no name,
/// message or file of a scenario can become markup.

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace evenstep {

/// A piece of HTML.
class Html {
 public:
  Html() = default;
  /// The text itself. Control characters, marks that change the direction of writing and other invisible characters are
  /// written as ⟨U+202E⟩ (line breaks and tabs stay); what is not UTF-8 becomes U+FFFD.
  Html(std::string_view text);  // NOLINT: text is what nearly all of a page is
  Html(const std::string& text) : Html(std::string_view(text)) {}
  Html(const char* text) : Html(std::string_view(text)) {}
  /// Text that is HTML (or SVG) already. Never for anything that comes from a file.
  static Html markup(std::string markup);

  Html& operator+=(const Html& other);
  friend Html operator+(Html a, const Html& b) { return std::move(a += b); }
  bool empty() const { return markup_.empty(); }
  const std::string& str() const { return markup_; }

 private:
  std::string markup_;
};

/// The values are escaped.
using Attributes = std::initializer_list<std::pair<std::string_view, std::string_view>>;
/// <name attributes>content</name>. Names of elements and attributes are evenstep's own, and are not escaped.
Html element(std::string_view name, Attributes attributes, const Html& content = {});
Html element(std::string_view name, const Html& content);

struct Column {
  std::string heading;
  bool number = false;  ///< right-aligned
};
/// A table; rows may have fewer cells than there are columns, never more. `caption` is read out by a screen reader, and
/// shown.
Html table(const std::string& caption, const std::vector<Column>& columns, const std::vector<std::vector<Html>>& rows);

/// Names and their values, one pair a line; pairs without a value are left out.
Html facts(const std::vector<std::pair<std::string, Html>>& pairs);

}  // namespace evenstep
