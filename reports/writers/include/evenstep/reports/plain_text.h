#pragma once
/// Text from elsewhere (names, messages, paths) made safe to print on one line, wherever that is.

#include <string>
#include <string_view>

namespace evenstep {

/// At most 200 characters on one line. Line breaks and tabs become spaces; control characters, marks that change the
/// direction of writing and other invisible ones are written as ⟨U+202E⟩; what is not UTF-8 becomes U+FFFD; "…" stands for
/// what was cut off.
std::string plain_text(std::string_view text);
/// The same, at most `most` characters, for GitHub's Markdown, also in the cell of a table: nothing in it is Markdown or
/// HTML, mentions a user or an issue, or is a link.
std::string markdown_text(std::string_view text, std::size_t most = 400);

}  // namespace evenstep
