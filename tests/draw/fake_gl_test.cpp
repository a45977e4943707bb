// The off-screen renderer on a fake EGL whose drivers fail as the test says. The functions of the program come before those
// of libEGL, which is opened on demand.
#include <optional>

#include "catch.h"
#include "drawn_scenes.h"
#include "evenstep/draw/canvas.h"
#include "src/gl_library.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

/// What the drivers do. Device 1 is hardware, device 2 is software.
struct Drivers {
  bool any = true, starts[3] = {true, true, true}, no_surface = true, current = true, compiles = true, links = true;
  int configs = 1;
  bool context = true, complete = true;
  GLenum error = GL_NO_ERROR;  // of each call of glGetError
};
Drivers drivers;
int contexts = 0, pictures_read = 0, opened = 0;

template <class Function>
struct Does;
template <class Value, class... Arguments>
struct Does<Value(Arguments...)> {
  static Value nothing(Arguments...) {
    if constexpr (!std::is_void_v<Value>) return Value{};
  }
};

const GLubyte* gl_get_string(GLenum) { return reinterpret_cast<const GLubyte*>("fake"); }
GLenum gl_check(GLenum) { return drivers.complete ? GL_FRAMEBUFFER_COMPLETE : GL_FRAMEBUFFER_UNSUPPORTED; }
GLenum gl_get_error() { return drivers.error; }
void gl_get_shader(GLuint, GLenum, GLint* done) { *done = drivers.compiles ? GL_TRUE : GL_FALSE; }
void gl_get_program(GLuint, GLenum, GLint* done) { *done = drivers.links ? GL_TRUE : GL_FALSE; }
void gl_get_log(GLuint, GLsizei size, GLsizei*, char* log) {
  std::snprintf(log, static_cast<std::size_t>(size), "line 3: no");
}
void gl_read_pixels(GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, void*) { ++pictures_read; }

EGLDeviceEXT device(std::intptr_t number) { return reinterpret_cast<EGLDeviceEXT>(number); }
EGLBoolean query_devices(EGLint, EGLDeviceEXT* devices, EGLint* count) {
  devices[0] = device(2);
  devices[1] = device(1);
  *count = drivers.any ? 2 : 0;
  return EGL_TRUE;
}
const char* device_string(EGLDeviceEXT of, EGLint) { return of == device(2) ? "EGL_a EGL_MESA_device_software" : "EGL_a"; }
EGLDisplay platform_display(EGLenum platform, void* of, const EGLint*) {
  return platform == EGL_PLATFORM_DEVICE_EXT ? static_cast<EGLDisplay>(of) : EGL_NO_DISPLAY;
}

using Any = __eglMustCastToProperFunctionPointerType;
const std::map<std::string, Any>& functions() {
  static const std::map<std::string, Any> all = [] {
    std::map<std::string, Any> made{
#define EVENSTEP_NOTHING(name) {#name, reinterpret_cast<Any>(&Does<decltype(::name)>::nothing)},
        EVENSTEP_GL_FUNCTIONS(EVENSTEP_NOTHING)
#undef EVENSTEP_NOTHING
    };
    made["glGetString"] = reinterpret_cast<Any>(&gl_get_string);
    made["glCheckFramebufferStatus"] = reinterpret_cast<Any>(&gl_check);
    made["glGetError"] = reinterpret_cast<Any>(&gl_get_error);
    made["glGetShaderiv"] = reinterpret_cast<Any>(&gl_get_shader);
    made["glGetProgramiv"] = reinterpret_cast<Any>(&gl_get_program);
    made["glGetShaderInfoLog"] = reinterpret_cast<Any>(&gl_get_log);
    made["glReadPixels"] = reinterpret_cast<Any>(&gl_read_pixels);
    made["eglQueryDevicesEXT"] = reinterpret_cast<Any>(&query_devices);
    made["eglQueryDeviceStringEXT"] = reinterpret_cast<Any>(&device_string);
    made["eglGetPlatformDisplayEXT"] = reinterpret_cast<Any>(&platform_display);
    return made;
  }();
  return all;
}

Result<std::unique_ptr<Canvas>, DrawError> canvas() {
  const TissueScene tissue = block({2, 2, 2});
  return make_canvas(100, 80, view_of(tissue, 100, 80), TissueMesh(tissue, 0).mesh());
}

/// False, after a warning, on a machine without libEGL.
bool has_libegl() {
  drivers = {};
  const auto made = canvas();
  if (!made) WARN("skipped: " << made.error().what);
  return made.ok();
}

}  // namespace

extern "C" {
Any eglGetProcAddress(const char* name) {
  const auto found = functions().find(name);
  return found == functions().end() ? nullptr : found->second;
}
const char* eglQueryString(EGLDisplay, EGLint) {
  return drivers.no_surface ? "EGL_KHR_surfaceless_context" : "EGL_KHR_other";
}
EGLBoolean eglInitialize(EGLDisplay display, EGLint*, EGLint*) {
  const auto number = reinterpret_cast<std::intptr_t>(display);
  if (!drivers.starts[number]) return EGL_FALSE;
  opened = static_cast<int>(number);
  return EGL_TRUE;
}
EGLBoolean eglBindAPI(EGLenum) { return EGL_TRUE; }
EGLBoolean eglChooseConfig(EGLDisplay, const EGLint*, EGLConfig*, EGLint, EGLint* count) {
  *count = drivers.configs;
  return EGL_TRUE;
}
EGLContext eglCreateContext(EGLDisplay, EGLConfig, EGLContext, const EGLint*) {
  if (!drivers.context) return EGL_NO_CONTEXT;
  ++contexts;
  return reinterpret_cast<EGLContext>(std::intptr_t{7});
}
EGLBoolean eglDestroyContext(EGLDisplay, EGLContext) { return --contexts, EGL_TRUE; }
EGLBoolean eglMakeCurrent(EGLDisplay, EGLSurface, EGLSurface, EGLContext) { return drivers.current; }
EGLint eglGetError() { return EGL_NOT_INITIALIZED; }
}

TEST_CASE("A driver of OpenGL that fails says where and what helps, and its context is given back") {
  if (!has_libegl()) return;
  const auto failure = [](auto change) {
    drivers = {};
    change(drivers);
    const auto made = canvas();
    drivers = {};
    CHECK(contexts == (made ? 1 : 0));
    if (made) return std::string("none");
    CHECK_FALSE(made.error().remedy.empty());
    return made.error().what;
  };
  CHECK(failure([](Drivers&) {}) == "none");
  CHECK(failure([](Drivers& d) { d.any = false; }) == "there is nothing to draw on: EGL knows no device");
  CHECK(failure([](Drivers& d) { d.starts[1] = d.starts[2] = false; }) ==
        "there is nothing to draw on: eglInitialize: error 0x3001");
  CHECK_THAT(failure([](Drivers& d) { d.no_surface = false; }), Contains("does not draw without a surface"));
  CHECK_THAT(failure([](Drivers& d) { d.configs = 0; }), Contains("it has no OpenGL ES 3 (EGL error 0x3001)"));
  CHECK_THAT(failure([](Drivers& d) { d.context = false; }), Contains("it has no OpenGL ES 3"));
  CHECK(failure([](Drivers& d) { d.current = false; }) == "the driver of OpenGL fails: eglMakeCurrent");
  CHECK(failure([](Drivers& d) { d.complete = false; }) == "the driver of OpenGL fails: it does not draw 100 x 80 pixels");
  CHECK(failure([](Drivers& d) { d.compiles = false; }) ==
        "the driver of OpenGL fails: a shader does not compile: line 3: no");
  CHECK(failure([](Drivers& d) { d.links = false; }) == "the driver of OpenGL fails: the shaders do not link");
  CHECK(failure([](Drivers& d) { d.error = GL_OUT_OF_MEMORY; }) == "the driver of OpenGL fails: out of memory");
  CHECK(failure([](Drivers& d) { d.error = GL_INVALID_OPERATION; }) == "the driver of OpenGL fails: OpenGL error 0x502");
}

TEST_CASE("Hardware is drawn on before software, whatever their order, and software where hardware does not start") {
  if (!has_libegl()) return;
  REQUIRE(canvas());
  CHECK(opened == 1);
  drivers.starts[1] = false;
  REQUIRE(canvas());
  CHECK(opened == 2);
}

TEST_CASE("A driver that fails while it is used ends the drawing with its words, and a picture has its size") {
  if (!has_libegl()) return;
  auto made = canvas();
  REQUIRE(made);
  const std::unique_ptr<Canvas> drawing = *std::move(made);
  CHECK(drawing->device() == "fake, fake");
  CHECK(drawing->draw({}));
  drivers.error = GL_OUT_OF_MEMORY;
  const auto full = drawing->draw({});
  REQUIRE_FALSE(full);
  CHECK(full.error().what == "the driver of OpenGL fails: out of memory");
  CHECK_THAT(full.error().remedy, Contains("a smaller picture"));
  drivers = {};
  drivers.current = false;
  const auto lost = drawing->draw({});
  REQUIRE_FALSE(lost);
  CHECK(lost.error().what == "the driver of OpenGL fails: eglMakeCurrent");
  const int before = pictures_read;
  CHECK(drawing->image().pixels.size() == 100 * 80 * 4);
  CHECK(pictures_read == before);
  drivers = {};
}
