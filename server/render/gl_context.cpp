#include "server/render/gl_context.hpp"

#include "engine/base/error.hpp"
#include "server/render/gl.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <thread>
#include <type_traits>

#include <GL/osmesa.h>
#include <dlfcn.h>

namespace tetfront {

namespace {

constexpr const char* library_name = "libOSMesa.so.8";

[[noreturn]] void fail(const std::string& problem) {
    throw InputError("OSMesa", "", problem, "install Mesa's software rasteriser (Debian: libosmesa6) 11.2 or newer");
}

/// What libOSMesa is asked for by its own names; everything else comes through GetProcAddress. Never unloaded: its
/// threads live as long as the process.
struct Library {
    decltype(&::OSMesaCreateContextAttribs) create;
    decltype(&::OSMesaDestroyContext) destroy;
    decltype(&::OSMesaMakeCurrent) make_current;
    decltype(&::OSMesaGetCurrentContext) current;
    decltype(&::OSMesaGetProcAddress) find;

    Library() {
        void* const library = ::dlopen(library_name, RTLD_NOW | RTLD_LOCAL);
        if (!library) fail(std::string("cannot be loaded: ") + ::dlerror());
        const auto take = [library](auto& function, const char* name) {
            function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(library, name));
            if (!function) fail(std::string("has no function ") + name);
        };
        take(create, "OSMesaCreateContextAttribs"), take(destroy, "OSMesaDestroyContext"), take(make_current, "OSMesaMakeCurrent");
        take(current, "OSMesaGetCurrentContext"), take(find, "OSMesaGetProcAddress");
        load_gl_functions(find);
    }
};

const Library& library() {
    static const Library loaded;
    return loaded;
}

}  // namespace

struct GlContext::Impl {
    const Library& mesa = library();
    OSMesaContext context = nullptr;
    std::thread::id thread = std::this_thread::get_id();
    // OSMesa wants a buffer for its window; we draw into framebuffer objects of our own.
    std::array<std::uint32_t, 16> window{};

    bool make_current() { return mesa.make_current(context, window.data(), GL_UNSIGNED_BYTE, 4, 4) == GL_TRUE; }
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
    impl_->context = impl_->mesa.create(attributes.data(), nullptr);
    if (!impl_->context || !impl_->make_current()) {
        if (impl_->context) impl_->mesa.destroy(impl_->context);
        fail("cannot make an OpenGL 3.3 core context");
    }
}

GlContext::~GlContext() {
    const Library& mesa = impl_->mesa;
    if (mesa.current() == impl_->context) mesa.make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
    mesa.destroy(impl_->context);
}

void GlContext::make_current() {
    ENSURE(std::this_thread::get_id() == impl_->thread, "the GL context is used from another thread than its own");
    ENSURE(impl_->mesa.current() == impl_->context || impl_->make_current(),
           "the GL context cannot be made current");
}

void GlContext::check_errors(const char* where) const {
    const GLenum error = glGetError();
    ENSURE(error == GL_NO_ERROR, "GL error ", error, " in ", where);
}

}  // namespace tetfront
