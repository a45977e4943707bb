// Any bytes as what a process solver writes: its first line, and then answers. The first byte says how many tools there
// are, and whether it has contacts.
#include <algorithm>

#include "property.h"
#include "src/process_answer.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::test;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::size_t tools = 1 + (data[0] & 1);
  const bool contacts = (data[0] & 2) != 0;
  const std::size_t end = std::min(bytes.find('\n'), bytes.size());
  const auto has = read_greeting(bytes.substr(0, end));
  require(!has.ok() || !has->particles, "a process has particles, for which there is no record");
  require(has.ok() || (!has.error().empty() && has.error().size() < 1000), "a refusal says nothing, or too much");
  bytes.remove_prefix(std::min(bytes.size(), end + 1));
  for (std::uint64_t n = 0; bytes.size() >= answer_size(tools, contacts); ++n) {
    const auto answer = read_answer(bytes.substr(0, answer_size(tools, contacts)), tools, contacts, RequestKind::step, n);
    if (!answer) return 0;
    require(answer->contacts.size() == (contacts ? tools : 0), "there is not one contact per tool");
    bytes.remove_prefix(answer_size(tools, contacts));
  }
  return 0;
}
