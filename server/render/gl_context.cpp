#include "server/render/gl_context.hpp"

#include "engine/base/error.hpp"
#include "server/render/gl.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <thread>

#include <GL/osmesa.h>

namespace tetfront {

struct GlContext::Impl {
    OSMesaContext context = nullptr;
    std::thread::id thread = std::this_thread::get_id();
    // OSMesa wants a buffer for its window; we draw into framebuffer objects of our own.
    std::array<std::uint32_t, 16> window{};

    bool make_current() { return OSMesaMakeCurrent(context, window.data(), GL_UNSIGNED_BYTE, 4, 4) == GL_TRUE; }
};

GlContext::GlContext() : impl_(std::make_unique<Impl>()) {
    const std::array<int, 15> attributes = {OSMESA_FORMAT,
                                            OSMESA_RGBA,
                                            OSMESA_DEPTH_BITS,
                                            0,
                                            OSMESA_STENCIL_BITS,
                                            0,
                                            OSMESA_ACCUM_BITS,
                                            0,
                                            OSMESA_PROFILE,
                                            OSMESA_CORE_PROFILE,
                                            OSMESA_CONTEXT_MAJOR_VERSION,
                                            3,
                                            OSMESA_CONTEXT_MINOR_VERSION,
                                            3,
                                            0};
    impl_->context = OSMesaCreateContextAttribs(attributes.data(), nullptr);
    if (!impl_->context || !impl_->make_current()) {
        if (impl_->context) OSMesaDestroyContext(impl_->context);
        throw InputError("OSMesa", "", "cannot make an OpenGL 3.3 core context",
                         "install Mesa's software rasteriser (Debian: libosmesa6) 11.2 or newer");
    }
}

GlContext::~GlContext() {
    if (OSMesaGetCurrentContext() == impl_->context) OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
    OSMesaDestroyContext(impl_->context);
}

void GlContext::make_current() {
    ENSURE(std::this_thread::get_id() == impl_->thread, "the GL context is used from another thread than its own");
    ENSURE(OSMesaGetCurrentContext() == impl_->context || impl_->make_current(),
           "the GL context cannot be made current");
}

void GlContext::check_errors(const char* where) const {
    const GLenum error = glGetError();
    ENSURE(error == GL_NO_ERROR, "GL error ", error, " in ", where);
}

}  // namespace tetfront
