// Any bytes as a recording of a live run, and as the contents of its blocks with right checksums (which no fuzzer would
// find).
#include "evenstep/harness/recorded_timing.h"
#include "evenstep/recordings/timing_csv.h"
#include "property.h"
#include "src/log/codec.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

void require_read_or_said(std::span<const std::byte> bytes) {
  const InputLogResult log = parse_input_log(bytes, "recording");
  const std::vector<Diagnostic> errors = log.error_or({});
  require(log.ok() == errors.empty(), "neither read nor refused");
  for (const Diagnostic& error : errors) require(!error.message.empty(), "an error without words");
  if (!log) return;
  require(log->bytes + log->left_bytes == static_cast<std::int64_t>(bytes.size()), "bytes that nobody counts");
  for (std::size_t tool = 0; tool < log->inputs.size(); ++tool)
    require(log->ticks[tool].size() == log->inputs[tool].ticks.size(), "ticks without their rest");
  static_cast<void>(format_timing_csv(recorded_timing(log->rows)));
}

}  // namespace

/// The contents of each block are a byte for the kind, two bytes for the length, and that many bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  require_read_or_said(bytes);
  std::vector<std::byte> framed = internal::file_begin();
  for (std::uint64_t sequence = 0; bytes.size() >= 3; ++sequence) {
    const auto kind = static_cast<internal::BlockKind>(bytes[0]);
    const std::size_t length =
        std::min(static_cast<std::size_t>(bytes[1]) + 256 * static_cast<std::size_t>(bytes[2]), bytes.size() - 3);
    const std::vector<std::byte> block = internal::block_bytes(kind, sequence, bytes.subspan(3, length));
    framed.insert(framed.end(), block.begin(), block.end());
    bytes = bytes.subspan(3 + length);
  }
  require_read_or_said(framed);
  return 0;
}
