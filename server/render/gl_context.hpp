#pragma once
// One OpenGL 3.3 core context without a display, current on the thread that made it.
//
//     GlContext context;                     // on the render thread
//     glClear(...);                          // from gl_functions.hpp, on the same thread only
//
// Made with OSMesa (Mesa's software rasteriser), whose library is loaded here. Mesa 25.1 drops OSMesa; EGL with the surfaceless platform gives the
// same rasteriser, and this class is the only place that would change. Keep one context per process: contexts of one
// process serialise each other, and making and destroying them leaks.

#include <memory>

namespace tetfront {

class GlContext {
 public:
    /// Throws InputError when the library is not there or makes no context.
    GlContext();
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    /// Makes it current again in case another context of this thread has been since. Throws LogicError on another
    /// thread than the constructor's: GL would corrupt memory there without a word.
    void make_current();
    /// Throws LogicError when a GL call since the last check failed. `where`: for the message.
    void check_errors(const char* where) const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace tetfront
