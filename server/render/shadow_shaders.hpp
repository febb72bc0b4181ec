#pragma once
// GLSL of what the lights see (depth maps) and of the floor with its baked darkness.

namespace tetfront::shaders {

/// Depth only, seen by a light.
inline constexpr const char* depth_vertex = R"glsl(
layout(location = 0) in vec3 position;
uniform mat4 clip_from_world;
void main() {
    gl_ClipDistance[0] = kept(position);
    gl_Position = clip_from_world * vec4(position, 1.0);
})glsl";
inline constexpr const char* depth_fragment = "void main() {}\n";

/// Share of the sky that the object hides from the floor, in floor coordinates: the sum of form factors
/// h^2 / (pi (h^2 + r^2)^2) dA of horizontal patches at height h and distance r.
inline constexpr const char* floor_sky_fragment = R"glsl(
in vec2 uv;
uniform sampler2D height;        // of the object's underside above the floor, 0..1 of `height_range`; 1: nothing
uniform float height_range;      // [m]
uniform float floor_width;       // [m] width of the square that all floor textures cover
uniform float size;
out vec4 result;
const int taps = 40;
void main() {
    float reach = 0.8 * size, sky = 0.0;
    vec2 way = pattern();
    for (int i = 0; i < taps; ++i) {
        float u = (float(i) + 0.5) / float(taps), r = reach * u;
        float h = texture(height, uv + r / floor_width * way).r;
        way = golden * way;
        float above = max(h * height_range, 0.05 * size), hh = above * above + r * r;
        sky += h < 1.0 ? u * above * above / (hh * hh) : 0.0;
    }
    result = vec4(min(1.0, sky * 2.0 * reach * reach / float(taps)));
})glsl";

/// Darkness of the floor: the key light's soft shadow, whose penumbra widens with the height of what casts it
/// (Fernando 2005), and the hidden share of the sky.
inline constexpr const char* floor_bake_fragment = R"glsl(
in vec2 uv;
uniform sampler2D light_depth;   // of the key light
uniform sampler2D hidden_sky;
uniform mat4 light_from_world;   // to texture space, 0..1
uniform mat4 world_from_floor;   // from (u, v) in 0..1
uniform float light_width;       // [m] width and depth range of the light's map
uniform float size;
out vec4 result;
const int search_taps = 8, shadow_taps = 14;
const float spread = 0.12;       // diameter over distance of the light: an area light, seen under 7 degrees
float key_shadow(vec3 light) {
    float search = spread * 0.5 * size / light_width, limit = min(light.z, 1.0);
    if (any(lessThan(light.xy, vec2(-search))) || any(greaterThan(light.xy, vec2(1.0 + search)))) return 0.0;
    float depth = 0.0, blockers = 0.0;
    vec2 way = pattern();
    for (int i = 0; i < search_taps; ++i) {
        float d = texture(light_depth, light.xy + search * spiral(i, search_taps) * way).r;
        way = golden * way;
        float blocks = d < limit ? 1.0 : 0.0;
        depth += blocks * d, blockers += blocks;
    }
    if (blockers == 0.0) return 0.0;
    float gap = (light.z - depth / blockers) * light_width;
    float radius = max(spread * gap, 0.008 * size) / light_width, key = 0.0;
    for (int i = 0; i < shadow_taps; ++i) {
        key += texture(light_depth, light.xy + radius * spiral(i, shadow_taps) * way).r < limit ? 1.0 : 0.0;
        way = golden * way;
    }
    return key / float(shadow_taps);
}
void main() {
    float key = key_shadow((light_from_world * (world_from_floor * vec4(uv, 0.0, 1.0))).xyz);
    float darkness = 1.0 - (1.0 - 0.34 * key) * (1.0 - 0.5 * texture(hidden_sky, uv).r);
    result = vec4(darkness * (1.0 - smoothstep(0.7, 1.0, length(2.0 * uv - 1.0))));
})glsl";

inline constexpr const char* floor_blur_fragment = R"glsl(
in vec2 uv;
uniform sampler2D source;
uniform vec2 direction;          // one texel along one axis
out vec4 result;
void main() {
    float sum = 0.0, weights = 0.0;
    for (int i = -3; i <= 3; ++i) {
        float w = exp(-0.22 * float(i * i));
        sum += w * texture(source, uv + float(i) * direction).r;
        weights += w;
    }
    result = vec4(sum / weights);
})glsl";

/// The floor shows nothing but its shadow: black with the baked darkness as alpha.
inline constexpr const char* floor_vertex = R"glsl(
uniform mat4 clip_from_world, world_from_floor;
out vec2 uv;
void main() {
    uv = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = clip_from_world * (world_from_floor * vec4(uv, 0.0, 1.0));
})glsl";
inline constexpr const char* floor_fragment = R"glsl(
in vec2 uv;
uniform sampler2D darkness;
uniform vec3 shade;              // encoded colour of the deepest shadow
out vec4 result;
void main() {
    float alpha = texture(darkness, uv).r;
    result = vec4(shade * alpha, alpha);
})glsl";

}  // namespace tetfront::shaders
