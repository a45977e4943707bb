#include "src/gl_library.h"

#include "evenstep/time/library_on_demand.h"

namespace evenstep::internal {
namespace {

GlLibrary load() {
  GlLibrary library;
#define EVENSTEP_BY_NAME(name) FunctionByName{#name, reinterpret_cast<void**>(&library.name)},
  library.missing = load_on_demand("libEGL.so.1", {EVENSTEP_EGL_FUNCTIONS(EVENSTEP_BY_NAME)}).value_or("");
#undef EVENSTEP_BY_NAME
  if (!library.missing.empty()) return library;
#define EVENSTEP_BY_NAME(name)                                                          \
  library.name = reinterpret_cast<decltype(&::name)>(library.eglGetProcAddress(#name)); \
  if (library.name == nullptr) library.missing = "libEGL.so.1 does not give " #name;
  EVENSTEP_GL_FUNCTIONS(EVENSTEP_BY_NAME)
#undef EVENSTEP_BY_NAME
  library.query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(library.eglGetProcAddress("eglQueryDevicesEXT"));
  library.device_string =
      reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(library.eglGetProcAddress("eglQueryDeviceStringEXT"));
  library.platform_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(library.eglGetProcAddress("eglGetPlatformDisplayEXT"));
  return library;
}

}  // namespace

const GlLibrary& gl() {
  static const GlLibrary library = load();
  return library;
}

}  // namespace evenstep::internal
