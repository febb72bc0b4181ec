#include "server/render/gl_functions.hpp"

#include "engine/base/error.hpp"

#include <string>

namespace tetfront {

#define TETFRONT_DEFINE(type, name) type name = nullptr;
TETFRONT_GL_FUNCTIONS(TETFRONT_DEFINE)
#undef TETFRONT_DEFINE

namespace {
template <class Function>
void take(Function& function, GlFunction found, const char* name) {
    if (!found)
        throw InputError("OSMesa", "", std::string("has no function ") + name, "install Mesa's software rasteriser (Debian: libosmesa6) 11.2 or newer");
    function = reinterpret_cast<Function>(found);
}
}  // namespace

void load_gl_functions(GlFunction (*find)(const char* name)) {
#define TETFRONT_LOAD(type, name) take(name, find(#name), #name);
    TETFRONT_GL_FUNCTIONS(TETFRONT_LOAD)
#undef TETFRONT_LOAD
}

}  // namespace tetfront
