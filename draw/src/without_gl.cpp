// In the place of OpenGL in a build without it (EVENSTEP_DRAW=OFF).
#include "evenstep/draw/canvas.h"

namespace evenstep {

bool built_with_drawing() { return false; }

Result<std::unique_ptr<Canvas>, DrawError> make_canvas(int, int, const View&, const Mesh&) {
  return Failure(DrawError{"this evenstep is built without OpenGL",
                           "install libegl-dev, libgles-dev and zlib1g-dev and build it with EVENSTEP_DRAW=ON, or write a "
                           "length or \"burn 11.1 ms\" in place of \"render\""});
}

Result<std::string> png_of(const Image&) { return Failure(std::string("this evenstep is built without OpenGL")); }

}  // namespace evenstep
