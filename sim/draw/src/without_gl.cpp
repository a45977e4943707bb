// In the place of OpenGL in a build without it (EVENSTEP_DRAW=OFF).
#include "evenstep/draw/canvas.h"
#include "evenstep/time/build_option.h"

namespace evenstep {

bool built_with_drawing() { return false; }

Result<std::unique_ptr<Canvas>, DrawError> make_canvas(int, int, const View&, const Mesh&) {
  return Failure(DrawError{built_without(build_option::kDraw), remedy_without(build_option::kDraw, kInsteadOfDrawing)});
}

Result<std::string> png_of(const Image&) { return Failure(refusal_without(build_option::kDraw)); }

}  // namespace evenstep
