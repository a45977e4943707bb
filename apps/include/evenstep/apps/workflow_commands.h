#pragma once
/// Output for a step of GitHub Actions: annotations, and the job's summary in Markdown. GitHub's runner takes every line of
/// stdout and stderr that begins with "::name" for a command, and also what follows "##[name" anywhere in a line; so text
/// from elsewhere must not pass unchanged. Written after actions/runner, ActionCommand.cs and OutputManager.cs. Also output
/// for a terminal, which takes control characters for commands.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/text/diagnostic.h"

namespace evenstep {

enum class AnnotationLevel { warning, error };

/// One line, with its end: "::error file=…,line=…,col=…,title=…::message". Whatever the parts contain, none can end early or
/// become another one. Of a place without a file, line or column, only what comes before that is written.
std::string annotation(AnnotationLevel level, const Place& place, std::string_view title, std::string_view message);

/// The file as an annotation names it: relative to the repository's folder if it lies below that, else as it is.
std::string file_in_repository(const std::string& file, const std::string& workspace);

/// Lets text through, in pieces, so that the runner finds no command in it: "::" at the start of a line becomes ":_:", "#["
/// becomes "#_[". Everything else stays the same.
class CommandGuard {
 public:
  std::string pass(std::string_view piece);

 private:
  enum class Start { blank, colon, text } start_ = Start::blank;
  char last_visible_ = 0;  ///< in this line; control characters and what is not ASCII do not count
};

/// Lets text through to a terminal, in pieces, so that nothing in it commands the terminal or changes the order in which it
/// is read: control characters, marks for writing from right to left, and bytes that are not UTF-8 become "?". Only the
/// sequences that evenstep itself writes are let through (its colours, and the one that clears a line of progress).
class TerminalGuard {
 public:
  std::string pass(std::string_view piece);

 private:
  std::string held_;  ///< the beginning of a character or sequence whose end is still to come
};

/// A row of the job's summary.
struct SummaryRow {
  std::string scenario, verdict, note;
};
/// A table of them, with a line of text below it; at most `most_bytes`, with fewer rows if need be. Nothing in a cell is
/// Markdown or HTML.
std::string summary_markdown(const std::vector<SummaryRow>& rows, std::string_view below, std::size_t most_bytes);

}  // namespace evenstep
