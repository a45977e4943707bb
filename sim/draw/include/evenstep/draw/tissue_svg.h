#pragma once
/// A picture of a mesh as SVG: the faces that are turned towards the eye, from the farthest to the nearest. It is drawn
/// without OpenGL, and the same mesh gives the same bytes on every machine. An arrow that the block hides shows through it,
/// dashed. Faces that cut each other are not split, so where a tool goes through the surface the edge between them is
/// ragged.

#include <span>
#include <string>

#include "evenstep/draw/tissue_mesh.h"
#include "evenstep/draw/view.h"

namespace evenstep {

struct SvgPicture {
  int width = 1600, height = 1200;  ///< of the view box
  std::string title;                ///< for readers who cannot see the picture; XML-escaped by tissue_svg
  /// The box that is drawn dashed behind everything, from the origin to this corner: the block at rest. glm::dvec3(0): none.
  glm::dvec3 outline_m{0};
};

/// Coordinates are clamped to ten times the picture's half width and half height from its middle.
std::string tissue_svg(const Mesh& mesh, const View& view, const SvgPicture& picture);

}  // namespace evenstep
