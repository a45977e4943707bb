#include "evenstep/apps/workflow_commands.h"

#include <random>

#include "catch.h"

using namespace evenstep;

namespace {

/// kBlank is what Char.IsWhiteSpace of .NET skips at the start of a line. A comparison by the rules of a language may skip
/// kSkipped anywhere.
const std::vector<std::string> kBlank{" ", "\t", "\v", "\f", "\u0085", "\u00a0", "\u2003"};
const std::vector<std::string> kSkipped{"\u0085", "\u00a0", "\u200b", "\ufeff", "\x01"};

/// Whether the most generous runner would find a command in this line, whatever the name of the command is.
bool is_command(std::string line) {
  for (const std::string& one : kSkipped) {
    for (std::size_t at = 0; (at = line.find(one, at)) != std::string::npos;) line.erase(at, one.size());
  }
  if (line.find("##[") != std::string::npos) return true;
  for (bool again = true; again;) {
    again = false;
    for (const std::string& one : kBlank) {
      if (!line.starts_with(one)) continue;
      line.erase(0, one.size());
      again = true;
    }
  }
  return line.starts_with("::");
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text) {
    if (c == '\n' || c == '\r')
      lines.emplace_back();
    else
      lines.back() += c;
  }
  return lines;
}

std::string random_text(std::mt19937& random) {
  std::vector<std::string> pieces{":", "::", "#", "##[", "[", "]", "\n", "\r", "\r\n", "a", "set-output name=x", "_", "%"};
  pieces.insert(pieces.end(), kBlank.begin(), kBlank.end());
  pieces.insert(pieces.end(), kSkipped.begin(), kSkipped.end());
  std::string text;
  for (unsigned i = random() % 20; i > 0; --i) text += pieces[random() % pieces.size()];
  return text;
}

}  // namespace

TEST_CASE("In 100,000 random texts in random pieces the runner finds no command, and only underscores were added",
          "[sweep]") {
  std::mt19937 random(1);
  std::size_t with_command = 0;
  for (int i = 0; i < 100'000; ++i) {
    const std::string text = random_text(random);
    CommandGuard guard;
    std::string passed;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t count = 1 + random() % 5;
      passed += guard.pass(std::string_view(text).substr(at, count));
      at += count;
    }
    for (const std::string& line : lines_of(text)) with_command += is_command(line) ? 1 : 0;
    bool found = false;
    for (const std::string& line : lines_of(passed)) found = found || is_command(line);
    std::size_t at = 0;
    for (const char c : passed) {
      if (at < text.size() && text[at] == c)
        ++at;
      else if (c != '_')
        found = true;
    }
    if (found || at != text.size()) FAIL_CHECK("'" << text << "' -> '" << passed << "'");
  }
  CHECK(with_command > 10'000);  // many texts really contain a command
}

TEST_CASE("Ordinary text passes unchanged") {
  for (const std::string text : {"evenstep 0.1.0  Figure 1: a, b\n", "x.toml:5:1: error: std::bad_alloc\n",
                                 "a #1 [b] ## [c]\n", "{\"a\": [\"::b\"]}\n", "\n"}) {
    CommandGuard guard;
    CHECK(guard.pass(text) == text);
  }
}

TEST_CASE("An annotation is one line whose parts stay what they are") {
  CHECK(annotation(AnnotationLevel::error, {"a/b.toml", 12, 3}, "title", "message") ==
        "::error file=a/b.toml,line=12,col=3,title=title::message\n");
  CHECK(annotation(AnnotationLevel::warning, {"a,b:c%.toml", 0, 0}, "x, y\n::z", "1: 100 %\r\n::set-output name=a::b") ==
        "::warning file=a%2Cb%3Ac%25.toml,title=x%2C y%0A%3A%3Az::1: 100 %25%0D%0A::set-output name=a::b\n");
  CHECK(annotation(AnnotationLevel::error, {"", 3, 4}, "t", "m") == "::error title=t::m\n");
}

TEST_CASE("A file is named from the repository's folder, if it is below it") {
  const std::string here = std::filesystem::current_path().string();
  CHECK(file_in_repository("a/../b.toml", here) == "b.toml");
  CHECK(file_in_repository("b.toml", here + "/") == "b.toml");
  CHECK(file_in_repository("../b.toml", here) == "../b.toml");
  CHECK(file_in_repository("/elsewhere/b.toml", here) == "/elsewhere/b.toml");
  CHECK(file_in_repository("b.toml", "") == "b.toml");
}

TEST_CASE("The summary is a table whatever its cells hold, and no larger than allowed") {
  const std::string text = summary_markdown({{"a|b.toml", "FAIL", "x\n| <b> [l](m) `c`"}}, "1 failed\n", 10'000);
  CHECK(text ==
        "### evenstep\n\n| scenario | verdict | |\n|---|---|---|\n"
        "| a\\|b.toml | FAIL | x \\| \\<b\\> \\[l\\](m) \\`c\\` |\n\n1 failed \n");
  const std::vector<SummaryRow> many(1000, {"x", "PASS", ""});
  for (std::size_t most = 0; most < 1000; ++most) CHECK(summary_markdown(many, "end", most).size() <= most);
  CHECK(summary_markdown(many, "end", 300).find(" more | | |\n\nend\n") != std::string::npos);
}

TEST_CASE("no text reaches a terminal as a command, wherever it is cut in two, but our own colours and line clearing do") {
  const std::string hostile =
      "a\x1b]0;title\x07"
      "b\x1b[2Jc\rd\x08"
      "e\u202Ef\u200Fg\u2066h\u061Ci\u009Bj\x9Bk\x7F\xE2\x80l\tm\n";
  const std::string shown = "a?]0;title?b?[2Jc?d?e?f?g?h?i?j?k???l\tm\n";
  const std::string ours = "\033[31mFAIL\033[0m \r\033[K \u00B5 \u65E5 \U0001F600\n";
  for (const auto& [text, expected] : {std::pair(hostile, shown), std::pair(ours, ours)}) {
    for (std::size_t cut = 0; cut <= text.size(); ++cut) {
      TerminalGuard guard;
      std::string passed = guard.pass(text.substr(0, cut));
      passed += guard.pass(text.substr(cut));
      CHECK(passed == expected);
    }
  }
}

TEST_CASE("an annotation has no control character but those of its own line") {
  CHECK(annotation(AnnotationLevel::error, {"a\x1b[2J", 1, 1}, "t\x07", "]]> <script> %0A\x1b[31m\n") ==
        "::error file=a?[2J,line=1,col=1,title=t?::]]> <script> %250A?[31m%0A\n");
}
