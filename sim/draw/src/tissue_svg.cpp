#include "evenstep/draw/tissue_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>

namespace evenstep {
namespace {

struct Point {
  int x = 0, y = 0;
};

Point pixel_of(const glm::dvec3& clip, const SvgPicture& picture) {
  const auto at = [](double share, int size) {
    return static_cast<int>(std::lround(std::clamp(share, -10.0, 10.0) * 0.5 * size + 0.5 * size));
  };
  return {at(clip.x, picture.width), at(-clip.y, picture.height)};
}

struct Drawn {
  const Face* face;
  double depth;  ///< of its middle
  std::uint32_t colour;
  bool lined;
};

std::uint32_t hex(const glm::vec3& colour, double brightness) {
  const auto part = [&](float share) {
    return static_cast<std::uint32_t>(std::lround(255 * std::clamp(share * brightness, 0.0, 1.0)));
  };
  return part(colour.r) << 16 | part(colour.g) << 8 | part(colour.b);
}

/// Mean of the colours of a face's corners.
glm::vec3 colour_of(const Mesh& mesh, const Face& face) {
  glm::vec3 sum(0);
  for (const std::uint32_t corner : face) sum += mesh.colours[corner];
  return 0.25F * sum;
}

/// The faces that are turned to the eye, the farthest first.
std::vector<Drawn> visible(const Mesh& mesh, const View& view) {
  std::vector<Drawn> drawn;
  for (const Face& face : mesh.faces) {
    const auto at = [&](std::size_t n) { return glm::dvec3(mesh.positions_m[face[n]]); };
    const glm::dvec3 normal = glm::cross(at(2) - at(0), at(3) == at(2) ? at(2) - at(1) : at(3) - at(1));
    if (!(glm::dot(normal, view.to_eye) > 0)) continue;
    const double depth = view.clip(0.25 * (at(0) + at(1) + at(2) + at(3))).z;
    drawn.push_back({&face, depth, hex(colour_of(mesh, face), brightness(view, normal)),
                     static_cast<std::size_t>(&face - mesh.faces.data()) < mesh.lined_faces});
  }
  std::stable_sort(drawn.begin(), drawn.end(), [](const Drawn& a, const Drawn& b) { return a.depth > b.depth; });
  return drawn;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

/// The edges of the box from 0 to `box_m`, one path.
std::string outline(const glm::dvec3& box_m, const View& view, const SvgPicture& picture) {
  std::string path;
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      if ((corner >> axis & 1) != 0) continue;
      const auto place = [&](int of) {
        return pixel_of(view.clip(box_m * glm::dvec3(of & 1, of >> 1 & 1, of >> 2 & 1)), picture);
      };
      const Point from = place(corner), to = place(corner | 1 << axis);
      path += fmt::format("M{} {}L{} {}", from.x, from.y, to.x, to.y);
    }
  }
  return path;
}

}  // namespace

std::string tissue_svg(const Mesh& mesh, const View& view, const SvgPicture& picture) {
  std::vector<Point> points;
  points.reserve(mesh.positions_m.size());
  for (const glm::vec3& position_m : mesh.positions_m) points.push_back(pixel_of(view.clip(position_m), picture));
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\"><title>{}</title>\n"
      "<rect width=\"{}\" height=\"{}\" fill=\"#{:06x}\"/>\n",
      picture.width, picture.height, escaped(picture.title), picture.width, picture.height, hex(kBackground, 1));
  if (picture.outline_m != glm::dvec3(0))
    svg += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#888\" stroke-width=\"3\" stroke-dasharray=\"12 9\"/>\n",
                       outline(picture.outline_m, view, picture));
  svg += "<g stroke=\"#000\" stroke-opacity=\".4\">\n";
  for (const Drawn& drawn : visible(mesh, view)) {
    const auto& [a, b, c, d] = *drawn.face;
    fmt::format_to(std::back_inserter(svg), "<path fill=\"#{:06x}\" d=\"M{} {}L{} {} {} {}", drawn.colour, points[a].x,
                   points[a].y, points[b].x, points[b].y, points[c].x, points[c].y);
    if (d != c) fmt::format_to(std::back_inserter(svg), " {} {}", points[d].x, points[d].y);
    svg += drawn.lined ? "z\"/>\n" : "z\" stroke=\"none\" shape-rendering=\"crispEdges\"/>\n";
  }
  svg += "</g>\n";
  for (const auto& [from_m, to_m] : mesh.arrows_m) {  // drawn last: the part that the block hides shows through
    const Point from = pixel_of(view.clip(from_m), picture), to = pixel_of(view.clip(to_m), picture);
    svg += fmt::format(
        "<path d=\"M{} {}L{} {}\" stroke=\"#000\" stroke-opacity=\".6\" stroke-width=\"7\" stroke-dasharray=\"14 9\"/>\n"
        "<circle cx=\"{}\" cy=\"{}\" r=\"6\" fill-opacity=\".6\"/>\n",
        from.x, from.y, to.x, to.y, to.x, to.y);
  }
  return svg + "</svg>\n";
}

}  // namespace evenstep
