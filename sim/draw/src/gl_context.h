#pragma once
/// A context of OpenGL ES 3 without a window.

#include <memory>
#include <string>

#include "evenstep/draw/canvas.h"
#include "src/gl_library.h"

namespace evenstep::internal {

class GlContext {
 public:
  /// On the device that canvas.h names.
  static Result<std::unique_ptr<GlContext>, DrawError> open();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// While it exists, OpenGL's functions act on this context in this thread, and in no other.
  class Current {
   public:
    explicit Current(const GlContext& context);
    ~Current();
    Current(const Current&) = delete;
    Current& operator=(const Current&) = delete;
    bool ok() const { return ok_; }

   private:
    EGLDisplay display_;
    bool ok_;
  };

 private:
  GlContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
  EGLDisplay display_;
  EGLContext context_;
};

}  // namespace evenstep::internal
