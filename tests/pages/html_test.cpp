
#include "evenstep/pages/html.h"
#include "catch.h"

namespace evenstep {
namespace {

TEST_CASE("text in a page is text, whatever it contains") {
  CHECK(Html("<script>alert(1)</script>").str() == "&lt;script&gt;alert(1)&lt;/script&gt;");
  CHECK(Html("a & \"b\" 'c' ]]>").str() == "a &amp; &quot;b&quot; &#39;c&#39; ]]&gt;");
  CHECK(Html("Ångström 力 🙂\n\tnext").str() == "Ångström 力 🙂\n\tnext");
}

TEST_CASE("what nobody sees in a text is written out") {
  CHECK(Html("\x1b[31mred").str() == "⟨U+001B⟩[31mred");
  CHECK(Html("abc\u202Egpj.exe").str() == "abc⟨U+202E⟩gpj.exe");
  CHECK(Html("a\u200Bb\u2066c\u00ADd\uFEFF").str() == "a⟨U+200B⟩b⟨U+2066⟩c⟨U+00AD⟩d⟨U+FEFF⟩");
  CHECK(Html(std::string_view("\0\x7F\r", 3)).str() == "⟨U+0000⟩⟨U+007F⟩⟨U+000D⟩");
  CHECK(Html("\U000E0041").str() == "⟨U+E0041⟩");
}

TEST_CASE("what is not UTF-8 becomes the replacement character") {
  CHECK(Html("a\xFF\xC0\xAF z").str() == "a\uFFFD\uFFFD\uFFFD z");
  CHECK(Html("\xED\xA0\x80").str() == "\uFFFD\uFFFD\uFFFD");
}

TEST_CASE("the value of an attribute cannot leave it") {
  CHECK(element("a", {{"title", "\" onclick=\"x()"}}, "t").str() == "<a title=\"&quot; onclick=&quot;x()\">t</a>");
}

TEST_CASE("a table has a caption, headings and a class for numbers") {
  const std::string text = table("What <b> is", {{"name"}, {"value", true}}, {{"a", "1"}, {"b"}}).str();
  CHECK(text.find("<caption>What &lt;b&gt; is</caption>") != std::string::npos);
  CHECK(text.find("<th scope=\"col\" class=\"number\">value</th>") != std::string::npos);
  CHECK(text.find("<td class=\"number\">1</td>") != std::string::npos);
}

TEST_CASE("facts without a value are left out") {
  CHECK(facts({{"a", "1"}, {"b", {}}}).str() == "<dl><div><dt>a</dt><dd>1</dd></div></dl>");
  CHECK(facts({{"b", {}}}).empty());
}

}  // namespace
}  // namespace evenstep
