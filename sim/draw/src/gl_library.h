#pragma once
/// The functions of EGL and OpenGL ES that are called. The first call opens libEGL, which provides those of OpenGL ES.

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>

#include <string>

// clang-format off
#define EVENSTEP_EGL_FUNCTIONS(X)                                                                                  \
  X(eglGetProcAddress) X(eglQueryString) X(eglInitialize) X(eglBindAPI) X(eglChooseConfig) X(eglCreateContext)     \
  X(eglDestroyContext) X(eglMakeCurrent) X(eglGetError)
#define EVENSTEP_GL_FUNCTIONS(X)                                                                                   \
  X(glAttachShader) X(glBindBuffer) X(glBindFramebuffer) X(glBindRenderbuffer) X(glBindVertexArray) X(glBufferData)\
  X(glBufferSubData) X(glCheckFramebufferStatus) X(glClear) X(glClearColor) X(glCompileShader) X(glCreateProgram)  \
  X(glCreateShader) X(glDeleteBuffers) X(glDeleteFramebuffers) X(glDeleteProgram) X(glDeleteRenderbuffers)         \
  X(glDeleteShader) X(glDeleteVertexArrays) X(glDrawElements) X(glEnable) X(glEnableVertexAttribArray) X(glFinish) \
  X(glFramebufferRenderbuffer) X(glGenBuffers) X(glGenFramebuffers) X(glGenRenderbuffers) X(glGenVertexArrays)     \
  X(glGetError) X(glGetProgramiv) X(glGetShaderInfoLog) X(glGetShaderiv) X(glGetString) X(glGetUniformLocation)    \
  X(glLinkProgram) X(glPolygonOffset) X(glReadPixels) X(glRenderbufferStorage) X(glShaderSource) X(glUniform3f) \
  X(glUniformMatrix4fv) X(glUseProgram) X(glVertexAttribPointer) X(glViewport)
// clang-format on

namespace evenstep::internal {

struct GlLibrary {
#define EVENSTEP_DECLARE(name) decltype(&::name) name = nullptr;
  EVENSTEP_EGL_FUNCTIONS(EVENSTEP_DECLARE)
  EVENSTEP_GL_FUNCTIONS(EVENSTEP_DECLARE)
#undef EVENSTEP_DECLARE
  // Functions of extensions; null where an extension is missing.
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;
  PFNEGLQUERYDEVICESTRINGEXTPROC device_string = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC platform_display = nullptr;
  std::string missing;  ///< what is missing, in the words of the dynamic linker; empty: nothing
};

const GlLibrary& gl();

}  // namespace evenstep::internal
