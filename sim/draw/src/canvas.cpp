#include "evenstep/draw/canvas.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/mat4x4.hpp>

#include "src/gl_context.h"

namespace evenstep {
namespace {

using internal::gl;
using internal::GlContext;

constexpr const char* kVertexShader = R"GLSL(#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 colour;
uniform mat4 seen;   // block coordinates -> right, up, to the eye
uniform vec3 halves; // of what is shown, along these
out vec3 place;
out vec3 paint;
void main() {
  place = (seen * vec4(position, 1.0)).xyz;
  paint = colour;
  gl_Position = vec4(place.xy / halves.xy, -place.z / halves.z, 1.0);
}
)GLSL";

// Each face has the brightness of its own normal, so that the lattice can be seen.
constexpr const char* kFragmentShader = R"GLSL(#version 300 es
precision highp float;
in vec3 place;
in vec3 paint;
uniform vec3 light;
uniform vec3 shades; // x: without light, y: of a line; z: 1 while lines are drawn
out vec4 colour;
void main() {
  if (shades.z > 0.5) {
    colour = vec4(paint * shades.y, 1.0);
    return;
  }
  vec3 normal = cross(dFdx(place), dFdy(place));
  float size = length(normal);
  normal = size > 0.0 ? normal / size : vec3(0.0, 0.0, 1.0);
  if (normal.z < 0.0) normal = -normal;
  colour = vec4(paint * (shades.x + (1.0 - shades.x) * max(0.0, dot(normal, light))), 1.0);
}
)GLSL";

/// Takes block coordinates to (right, up, to the eye), measured from the view's center.
glm::mat4 seen_from(const View& view) {
  glm::mat4 seen(1);
  const std::array<glm::dvec3, 3> rows{view.right, view.up, view.to_eye};
  for (int row = 0; row < 3; ++row) {
    const glm::dvec3& axis = rows[static_cast<std::size_t>(row)];
    for (int column = 0; column < 3; ++column) seen[column][row] = static_cast<float>(axis[column]);
    seen[3][row] = static_cast<float>(-glm::dot(axis, view.center_m));
  }
  return seen;
}

DrawError driver_error(const std::string& what) {
  return {"the driver of OpenGL fails: " + what, "a smaller picture ([timing] picture), or another driver"};
}

/// Empty, or what OpenGL has reported since the last call.
std::string gl_error() {
  const GLenum first = gl().glGetError();
  if (first == GL_NO_ERROR) return {};
  for (int n = 0; n < 8 && gl().glGetError() != GL_NO_ERROR; ++n) continue;
  return first == GL_OUT_OF_MEMORY ? "out of memory" : fmt::format("OpenGL error 0x{:x}", first);
}

class GlCanvas final : public Canvas {
 public:
  GlCanvas(std::unique_ptr<GlContext> context, int width, int height)
      : context_(std::move(context)), width_(width), height_(height) {}
  ~GlCanvas() override {
    const GlContext::Current current(*context_);
    if (!current.ok()) return;
    gl().glDeleteProgram(program_);
    gl().glDeleteBuffers(static_cast<GLsizei>(buffers_.size()), buffers_.data());
    gl().glDeleteVertexArrays(1, &vertices_);
    gl().glDeleteRenderbuffers(static_cast<GLsizei>(layers_.size()), layers_.data());
    gl().glDeleteFramebuffers(1, &target_);
  }

  /// Empty, or what went wrong.
  std::string prepare(const View& view, const Mesh& mesh) {
    const GlContext::Current current(*context_);
    if (!current.ok()) return "eglMakeCurrent";
    const auto text = [](GLenum what) { return reinterpret_cast<const char*>(gl().glGetString(what)); };
    device_ = fmt::format("{}, {}", text(GL_RENDERER), text(GL_VERSION));
    std::string error = make_target();
    if (error.empty()) error = make_program(view);
    if (!error.empty()) return error;
    make_buffers(mesh);
    return gl_error();
  }

  Result<bool, DrawError> draw(const std::vector<glm::vec3>& positions_m) override {
    return draw_share(positions_m, 0, kWholeDrawing);
  }

  Result<bool, DrawError> draw_share(const std::vector<glm::vec3>& positions_m, int from, int to) override {
    const GlContext::Current current(*context_);
    if (!current.ok()) return Failure(driver_error("eglMakeCurrent"));
    if (from == 0) {
      gl().glBindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
      const std::size_t bytes = std::min(positions_m.size() * sizeof(glm::vec3), positions_bytes_);
      gl().glBufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(bytes), positions_m.data());
      gl().glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    }
    draw_between(GL_TRIANGLES, 3, 0, corners_, from, to);
    draw_between(GL_LINES, 2, corners_, ends_, from, to);
    gl().glFinish();
    const std::string error = gl_error();
    if (!error.empty()) return Failure(driver_error(error));
    return true;
  }

  Image image() override {
    Image image{width_, height_, {}};
    const std::size_t row = static_cast<std::size_t>(width_) * 4, rows = static_cast<std::size_t>(height_);
    image.pixels.resize(row * rows);
    const GlContext::Current current(*context_);
    if (!current.ok()) return image;
    gl().glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
    for (std::size_t y = 0; y < rows / 2; ++y)  // OpenGL's first row is the lowest one
      std::swap_ranges(image.pixels.begin() + static_cast<std::ptrdiff_t>(y * row),
                       image.pixels.begin() + static_cast<std::ptrdiff_t>((y + 1) * row),
                       image.pixels.begin() + static_cast<std::ptrdiff_t>((rows - 1 - y) * row));
    return image;
  }

  const std::string& device() const override { return device_; }

 private:
  /// Draws those of the `count` corners or ends from `first` on that lie in this share of the whole list; `each` of them
  /// make a triangle or a line.
  void draw_between(GLenum what, GLsizei each, GLsizei first, GLsizei count, int from, int to) const {
    const auto whole = static_cast<std::int64_t>(corners_) + ends_;
    const auto at = [&](int share) {
      const std::int64_t wanted = whole * std::min(share, kWholeDrawing) / kWholeDrawing - first;
      return static_cast<GLsizei>(std::clamp<std::int64_t>(wanted, 0, count) / each * each);
    };
    if (at(from) < at(to)) draw_elements(what, first + at(from), at(to) - at(from));
  }
  void draw_elements(GLenum what, GLsizei first, GLsizei count) const {
    gl().glUniform3f(shades_, static_cast<float>(kAmbient), static_cast<float>(kLine), what == GL_LINES ? 1 : 0);
    const auto at = static_cast<std::uintptr_t>(first) * sizeof(std::uint32_t);
    gl().glDrawElements(what, count, GL_UNSIGNED_INT, reinterpret_cast<const void*>(at));
  }

  std::string make_target() {
    gl().glGenFramebuffers(1, &target_);
    gl().glBindFramebuffer(GL_FRAMEBUFFER, target_);
    gl().glGenRenderbuffers(static_cast<GLsizei>(layers_.size()), layers_.data());
    const std::array<GLenum, 2> formats{GL_RGBA8, GL_DEPTH_COMPONENT24};
    const std::array<GLenum, 2> places{GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
    for (std::size_t n = 0; n < layers_.size(); ++n) {
      gl().glBindRenderbuffer(GL_RENDERBUFFER, layers_[n]);
      gl().glRenderbufferStorage(GL_RENDERBUFFER, formats[n], width_, height_);
      gl().glFramebufferRenderbuffer(GL_FRAMEBUFFER, places[n], GL_RENDERBUFFER, layers_[n]);
    }
    if (gl().glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      return fmt::format("it does not draw {} x {} pixels", width_, height_);
    gl().glViewport(0, 0, width_, height_);
    gl().glEnable(GL_DEPTH_TEST);
    gl().glEnable(GL_POLYGON_OFFSET_FILL);  // faces a little farther away than the lines on them
    gl().glPolygonOffset(1, 1);
    gl().glClearColor(kBackground.r, kBackground.g, kBackground.b, 1);
    return {};
  }

  std::string add_shader(GLenum kind, const char* source) const {
    const GLuint shader = gl().glCreateShader(kind);
    gl().glShaderSource(shader, 1, &source, nullptr);
    gl().glCompileShader(shader);
    GLint done = 0;
    gl().glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
    std::array<char, 512> log{};
    if (done == GL_FALSE) gl().glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    gl().glAttachShader(program_, shader);
    gl().glDeleteShader(shader);  // when the program is deleted
    return done == GL_FALSE ? fmt::format("a shader does not compile: {}", log.data()) : "";
  }

  std::string make_program(const View& view) {
    program_ = gl().glCreateProgram();
    for (const auto& [kind, source] :
         {std::pair(GL_VERTEX_SHADER, kVertexShader), std::pair(GL_FRAGMENT_SHADER, kFragmentShader)})
      if (std::string error = add_shader(static_cast<GLenum>(kind), source); !error.empty()) return error;
    gl().glLinkProgram(program_);
    GLint done = 0;
    gl().glGetProgramiv(program_, GL_LINK_STATUS, &done);
    if (done == GL_FALSE) return "the shaders do not link";
    gl().glUseProgram(program_);
    const glm::mat4 seen = seen_from(view);
    const auto uniform = [&](const char* name) { return gl().glGetUniformLocation(program_, name); };
    gl().glUniformMatrix4fv(uniform("seen"), 1, GL_FALSE, &seen[0][0]);
    gl().glUniform3f(uniform("halves"), static_cast<float>(view.half_width_m), static_cast<float>(view.half_height_m),
                     static_cast<float>(view.half_depth_m));
    gl().glUniform3f(uniform("light"), static_cast<float>(kLight.x), static_cast<float>(kLight.y),
                     static_cast<float>(kLight.z));
    shades_ = uniform("shades");
    return {};
  }

  void make_buffers(const Mesh& mesh) {
    positions_bytes_ = mesh.positions_m.size() * sizeof(glm::vec3);
    std::vector<std::uint32_t> corners;
    for (const auto& [a, b, c, d] : mesh.faces) {
      corners.insert(corners.end(), {a, b, c});
      if (d != c) corners.insert(corners.end(), {a, c, d});
    }
    corners_ = static_cast<GLsizei>(corners.size());
    for (std::size_t n = 0; n < mesh.lined_faces; ++n) {
      const auto& [a, b, c, d] = mesh.faces[n];
      // Surfaces are closed: the two faces of an edge run through it in opposite directions, and one of them draws it.
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, d), std::pair(d, a)})
        if (from < to) corners.insert(corners.end(), {from, to});
    }
    ends_ = static_cast<GLsizei>(corners.size()) - corners_;
    gl().glGenVertexArrays(1, &vertices_);
    gl().glBindVertexArray(vertices_);
    gl().glGenBuffers(static_cast<GLsizei>(buffers_.size()), buffers_.data());
    const std::array<const std::vector<glm::vec3>*, 2> attributes{&mesh.positions_m, &mesh.colours};
    for (GLuint n = 0; n < 2; ++n) {
      gl().glBindBuffer(GL_ARRAY_BUFFER, buffers_[n]);
      gl().glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(positions_bytes_), attributes[n]->data(),
                        n == 0 ? GL_STREAM_DRAW : GL_STATIC_DRAW);
      gl().glVertexAttribPointer(n, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
      gl().glEnableVertexAttribArray(n);
    }
    gl().glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[2]);
    gl().glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(std::uint32_t)),
                      corners.data(), GL_STATIC_DRAW);
  }

  std::unique_ptr<GlContext> context_;
  int width_, height_;
  std::string device_;
  GLuint program_ = 0, target_ = 0, vertices_ = 0;
  std::array<GLuint, 2> layers_{};   // colour and depth
  std::array<GLuint, 3> buffers_{};  // positions, colours, corners of triangles and ends of lines
  GLint shades_ = -1;
  GLsizei corners_ = 0, ends_ = 0;
  std::size_t positions_bytes_ = 0;
};

}  // namespace

bool built_with_drawing() { return true; }

Result<std::unique_ptr<Canvas>, DrawError> make_canvas(int width, int height, const View& view, const Mesh& mesh) {
  if (std::min(width, height) < kLeastCanvas || std::max(width, height) > kMostCanvas)
    return Failure(DrawError{fmt::format("a picture of {} x {} pixels cannot be drawn", width, height),
                             fmt::format("{} to {} in both directions", kLeastCanvas, kMostCanvas)});
  auto context = GlContext::open();
  if (!context) return Failure(context.error());
  auto canvas = std::make_unique<GlCanvas>(*std::move(context), width, height);
  if (const std::string error = canvas->prepare(view, mesh); !error.empty()) return Failure(driver_error(error));
  if (const auto drawn = canvas->draw(mesh.positions_m); !drawn) return Failure(drawn.error());
  return std::unique_ptr<Canvas>(std::move(canvas));
}

}  // namespace evenstep
