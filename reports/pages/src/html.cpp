#include "evenstep/pages/html.h"

#include <fmt/format.h>

#include "evenstep/reports/unicode.h"

namespace evenstep {
namespace {

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const char32_t c = take_code_point(text);
    if (is_unseen(c) && c != '\n' && c != '\t')
      out += fmt::format("⟨U+{:04X}⟩", static_cast<unsigned>(c));
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else
      append_utf8(out, c);
  }
  return out;
}

}  // namespace

Html::Html(std::string_view text) : markup_(escaped(text)) {}

Html Html::markup(std::string markup) {
  Html html;
  html.markup_ = std::move(markup);
  return html;
}

Html& Html::operator+=(const Html& other) {
  markup_ += other.markup_;
  return *this;
}

Html element(std::string_view name, Attributes attributes, const Html& content) {
  std::string out = fmt::format("<{}", name);
  for (const auto& [key, value] : attributes) out += fmt::format(" {}=\"{}\"", key, escaped(value));
  return Html::markup(fmt::format("{}>{}</{}>", out, content.str(), name));
}

Html element(std::string_view name, const Html& content) { return element(name, {}, content); }

Html table(const std::string& caption, const std::vector<Column>& columns, const std::vector<std::vector<Html>>& rows) {
  std::vector<bool> used(columns.size(), rows.empty());
  for (const std::vector<Html>& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) used.at(i) = used[i] || !row[i].empty();
  }
  const auto kind = [&](std::size_t i) { return columns[i].number ? "number" : "words"; };
  Html head, body;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (used[i]) head += element("th", {{"scope", "col"}, {"class", kind(i)}}, columns[i].heading);
  }
  for (const std::vector<Html>& row : rows) {
    Html cells;
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (used[i]) cells += element("td", {{"class", kind(i)}}, row[i]);
    }
    body += element("tr", cells) + Html::markup("\n");
  }
  const Html whole = element("caption", caption) + element("thead", element("tr", head)) + element("tbody", body);
  return element("div", {{"class", "wide"}, {"tabindex", "0"}, {"role", "region"}, {"aria-label", caption}},
                 element("table", whole));
}

Html facts(const std::vector<std::pair<std::string, Html>>& pairs) {
  Html list;
  for (const auto& [name, value] : pairs) {
    if (!value.empty()) list += element("div", element("dt", name) + element("dd", value));
  }
  return list.empty() ? Html() : element("dl", list);
}

}  // namespace evenstep
