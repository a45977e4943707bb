#include "src/gl_context.h"

#include <fmt/format.h>

#include <array>
#include <string_view>
#include <vector>

namespace evenstep::internal {
namespace {

constexpr const char* kRemedy =
    "install a driver of OpenGL for EGL: libegl1 with a GPU's own, or libegl-mesa0 and libgl1-mesa-dri, which draw on the "
    "processor; or write a length or \"burn 11.1 ms\" in place of \"render\"";

bool names(const char* list, std::string_view name) {
  return list != nullptr && (" " + std::string(list) + " ").find(" " + std::string(name) + " ") != std::string::npos;
}

/// The displays to try, in this order: those of hardware devices, those of software devices, Mesa's without a surface.
std::vector<EGLDisplay> displays() {
  std::vector<EGLDisplay> hardware, software;
  if (gl().platform_display == nullptr) return {};
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  if (gl().query_devices != nullptr && gl().device_string != nullptr &&
      gl().query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_TRUE) {
    for (EGLint n = 0; n < count; ++n) {
      const EGLDeviceEXT device = devices.at(static_cast<std::size_t>(n));
      const bool is_software = names(gl().device_string(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
      (is_software ? software : hardware).push_back(gl().platform_display(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
    }
  }
  software.push_back(gl().platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  hardware.insert(hardware.end(), software.begin(), software.end());
  return hardware;
}

/// A context on this display; null, with the reason, if there is none.
EGLContext context_on(EGLDisplay display, std::string& why) {
  if (gl().eglInitialize(display, nullptr, nullptr) != EGL_TRUE) {
    why = fmt::format("eglInitialize: error 0x{:x}", gl().eglGetError());
    return EGL_NO_CONTEXT;
  }
  if (!names(gl().eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context")) {
    why = "the driver does not draw without a surface (EGL_KHR_surfaceless_context)";
    return EGL_NO_CONTEXT;
  }
  constexpr std::array<EGLint, 5> kConfig{EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_NONE};
  constexpr std::array<EGLint, 3> kContext{EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  EGLContext context = EGL_NO_CONTEXT;
  if (gl().eglBindAPI(EGL_OPENGL_ES_API) == EGL_TRUE &&
      gl().eglChooseConfig(display, kConfig.data(), &config, 1, &count) == EGL_TRUE && count > 0)
    context = gl().eglCreateContext(display, config, EGL_NO_CONTEXT, kContext.data());
  if (context == EGL_NO_CONTEXT) why = fmt::format("it has no OpenGL ES 3 (EGL error 0x{:x})", gl().eglGetError());
  return context;
}

}  // namespace

Result<std::unique_ptr<GlContext>, DrawError> GlContext::open() {
  if (!gl().missing.empty()) return Failure(DrawError{"OpenGL cannot be loaded: " + gl().missing, kRemedy});
  std::string why = "EGL knows no device";
  // A display is never closed: other parts of this process may draw on it.
  for (EGLDisplay display : displays()) {
    if (display == EGL_NO_DISPLAY) continue;
    const EGLContext context = context_on(display, why);
    if (context != EGL_NO_CONTEXT) return std::unique_ptr<GlContext>(new GlContext(display, context));
  }
  return Failure(DrawError{"there is nothing to draw on: " + why, kRemedy});
}

GlContext::~GlContext() { gl().eglDestroyContext(display_, context_); }

GlContext::Current::Current(const GlContext& context)
    : display_(context.display_),
      ok_(gl().eglBindAPI(EGL_OPENGL_ES_API) == EGL_TRUE &&
          gl().eglMakeCurrent(context.display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_) == EGL_TRUE) {}
GlContext::Current::~Current() { gl().eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

}  // namespace evenstep::internal
