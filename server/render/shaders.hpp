#pragma once
// The renderer's GLSL: what several programs share. Everything is computed in linear light and world space [m]; only
// what goes into the picture is sRGB-encoded, with premultiplied alpha. `size` is a length of the object [m] that scales
// all distances. The programs themselves are in shadow_, visibility_ and surface_shaders.hpp.

namespace tetfront::shaders {

inline constexpr const char* version = "#version 330 core\n";

/// One triangle that covers the viewport; no vertex buffer.
inline constexpr const char* full_screen_vertex = R"glsl(
out vec2 uv;
void main() {
    uv = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
})glsl";

/// Taps around a fragment. n points that fill the unit disc evenly (Vogel's spiral): the i-th is spiral(i, n) * way, and then
/// way = golden * way.
inline constexpr const char* sampling = R"glsl(
const mat2 golden = mat2(-0.737368878, 0.675490294, -0.675490294, -0.737368878);
float spiral(int i, int n) { return sqrt((float(i) + 0.5) / float(n)); }
// Where way begins: one of 16 directions in a 4x4 pattern of pixels, which a blur of 4x4 averages out.
vec2 pattern() {
    ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
    float turn = float((cell.x * 5 + cell.y * 7 + (cell.x ^ cell.y) * 3) & 15) * (6.28318531 / 16.0);
    return vec2(cos(turn), sin(turn));
}
)glsl";

inline constexpr const char* colours = R"glsl(
// sRGB's curve within 0.3/255 above 0.002, by square roots: its power is what a fragment would wait for longest.
vec3 encode(vec3 c) {
    vec3 s = sqrt(c), t = sqrt(s);
    return max(0.662002687 * s + 0.684122060 * t - 0.323583601 * sqrt(t) - 0.0225411470 * c, 0.0);
}
float decode(float x) { return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4); }
vec3 decode(vec3 c) { return vec3(decode(c.r), decode(c.g), decode(c.b)); }
)glsl";

/// The view's cut, `cut` = (normal, normal . point) or zeros: what lies beyond is clipped. Where the object's inner side
/// shows through the opening, the point of the plane before it takes its place, so that a closed surface looks solid.
inline constexpr const char* cut_vertex = R"glsl(
uniform vec4 cut;
float kept(vec3 position) { return cut.w - dot(cut.xyz, position); }
)glsl";
inline constexpr const char* define_cut = "#define CUT\n";  // for programs that are used only when there is a cut
inline constexpr const char* cut_fragment = R"glsl(
uniform vec4 cut;
uniform vec3 eye_position;
bool on_cap(inout vec3 world) {
    vec3 way = world - eye_position;
    float along = dot(cut.xyz, way);
    if (gl_FrontFacing || along >= 0.0) return false;
    float t = (cut.w - dot(cut.xyz, eye_position)) / along;
    if (t <= 0.0 || t >= 1.0) return false;
    world = eye_position + t * way;
    return true;
})glsl";

}  // namespace tetfront::shaders
