#pragma once
/// Draws a mesh with OpenGL ES 3 off screen, through EGL: on a GPU, or on the processor where Mesa's llvmpipe stands in for
/// a GPU.
///
/// libEGL is opened by the first make_canvas, and by nothing else: a program that draws nothing loads no OpenGL. Of the
/// devices that EGL knows, the first that is not software is taken, otherwise a software one, otherwise Mesa's platform
/// without a surface.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/draw/tissue_mesh.h"
#include "evenstep/draw/view.h"
#include "evenstep/time/result.h"

namespace evenstep {

inline constexpr int kLeastCanvas = 16, kMostCanvas = 8192;  ///< pixels, for width and height
inline constexpr int kWholeDrawing = 1000;                   ///< into how many parts a drawing can be cut

struct DrawError {
  std::string what, remedy;
};

/// Rows from top to bottom, width x height x (red, green, blue, opacity).
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

class Canvas {
 public:
  virtual ~Canvas() = default;
  /// Gives the device the positions (as many as the mesh had that the canvas was made for), draws, and waits until all is
  /// drawn. It may be called by any thread, one at a time.
  virtual Result<bool, DrawError> draw(const std::vector<glm::vec3>& positions_m) = 0;
  /// Draws only the parts [from, to) of kWholeDrawing; 0 <= from < to. All shares from 0 on, in order and of the same
  /// positions, give the picture that draw() gives. That picture is not there before the last share.
  virtual Result<bool, DrawError> draw_share(const std::vector<glm::vec3>& positions_m, int from, int to) = 0;
  /// What was drawn last.
  virtual Image image() = 0;
  /// "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL ES 3.2 Mesa 22.3.6"
  virtual const std::string& device() const = 0;
};

/// Compiles all that is needed and draws once, so that the first draw() is like the later ones. Errors: this evenstep is
/// built without OpenGL, no libEGL, no device, a size outside the limits, an error of the driver.
Result<std::unique_ptr<Canvas>, DrawError> make_canvas(int width, int height, const View& view, const Mesh& mesh);
/// Whether this evenstep can draw at all (EVENSTEP_DRAW).
bool built_with_drawing();
/// What a scenario can have instead, for messages.
inline constexpr std::string_view kInsteadOfDrawing = "write a length or \"burn 11.1 ms\" in place of \"render\"";

/// The image as a PNG file. Errors: zlib is not there.
Result<std::string> png_of(const Image& image);

}  // namespace evenstep
