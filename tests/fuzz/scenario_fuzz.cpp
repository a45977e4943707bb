// Any bytes as a scenario file. What is read must read back from its resolved table as the same scenario.
#include <filesystem>

#include "../format/support.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;
using evenstep::testing::TemporaryFolder;

namespace {

/// The folder beside the input has what an input can name in `extends`, `trace` and `file`: the shipped scenarios of the
/// paper, and a recording and a motion that are short enough to be read thousands of times a second.
const TemporaryFolder& folder() {
  static const TemporaryFolder made;
  static const bool filled = [] {
    namespace fs = std::filesystem;
    for (const fs::directory_entry& entry : fs::directory_iterator(EVENSTEP_SOURCE_DIR "/scenarios/paper")) {
      fs::copy_file(entry.path(), made.path() / entry.path().filename());
    }
    made.write("t.csv",
               "segment,kind,index,begin_ns,end_ns\n0,visualization,0,100,10100\n0,step,0,10100,14100\n"
               "0,idle,0,18200,30100\n1,visualization,0,30100,42100\n1,step,0,42100,46100\n");
    made.write("m.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n0.5,1e-3,-2e-3,0.5\n");
    return true;
  }();
  static_cast<void>(filled);
  return made;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string input(reinterpret_cast<const char*>(data), size);
  const ReadResult result = read_scenario(folder().write("s.toml", input));
  require_read_or_refused(result.ok(), result.error_or({}));
  if (!result) return 0;
  const ReadResult again = read_scenario(folder().write("r.toml", result->resolved_toml));
  require(again.ok(), "the resolved scenario is refused: " + errors_of(again));
  require(describe(*again) == describe(*result), "the resolved scenario is another one");
  require(again->resolved_toml == result->resolved_toml, "the resolved scenario resolves to another text");
  return 0;
}
