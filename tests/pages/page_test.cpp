
#include "evenstep/pages/page.h"
#include "catch.h"

namespace evenstep {
namespace {

using Catch::Contains;

std::string page_with(const std::string& name, const std::string& charts = "") {
  Page page{name,  "run", "pass", element("p", name), "evenstep run " + name, {{"facts", "Facts", facts({{name, name}})}},
            charts};
  return html_of(page);
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST_CASE("a page allows only its own scripts and styles, and fetches nothing") {
  const std::string text = page_with("figure 1");
  CHECK_THAT(text, Contains("default-src 'none'; script-src 'sha256-"));
  CHECK_FALSE(text.find("unsafe") < text.size());
  for (const char* way_out : {"src=", "@import", "url(", "<link", "<iframe", "<form"}) {
    INFO(way_out);
    CHECK(text.find(way_out) == std::string::npos);
  }
}

TEST_CASE("a hostile name stays a name in every part of a page") {
  const std::string honest = page_with("honest"),
                    hostile = page_with("</title></style><script>alert(1)</script>]]>\u202E\x1b");
  for (const char* markup : {"<script", "</script", "</style", "</title", "<p", "<dt"})
    CHECK(count(hostile, markup) == count(honest, markup));
  CHECK(hostile.find("\u202E") == std::string::npos);
  CHECK(hostile.find('\x1b') == std::string::npos);
}

TEST_CASE("data of charts cannot end its element") {
  const std::string text = page_with("a", R"({"name":"</script><!--"})");
  CHECK_THAT(text, Contains(R"({"name":"\u003c/script>\u003c!--"})"));
}

TEST_CASE("a page without charts does not carry the library that draws them") {
  CHECK(page_with("a").size() < 20'000);
  CHECK_THAT(page_with("a", "{}"), Contains("uPlot") && Contains("Permission is hereby granted"));
}

TEST_CASE("sections without a body are left out, of the contents too") {
  const std::string text = html_of({"t", "", "", {}, "", {{"a", "Full", "x"}, {"b", "Void", {}}}, ""});
  CHECK_THAT(text, Contains("href=\"#a\"") && !Contains("Void"));
}

}  // namespace
}  // namespace evenstep
