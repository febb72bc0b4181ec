#pragma once
// GLSL of how much of the sky and of the key light each visible point sees.

namespace tetfront::shaders {

/// Eye-space normal as a colour, and depth, for ambient occlusion.
inline constexpr const char* eye_vertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 eye_from_world, clip_from_eye;
out vec3 world, eye_normal;
void main() {
    world = position;
    eye_normal = mat3(eye_from_world) * normal;
    gl_ClipDistance[0] = kept(position);
    gl_Position = clip_from_eye * eye_from_world * vec4(position, 1.0);
})glsl";
/// CUT is defined when the view has a cut: writing depth costs the early depth test.
inline constexpr const char* eye_fragment = R"glsl(
in vec3 world, eye_normal;
uniform mat4 eye_from_world, clip_from_eye;
out vec4 result;
void main() {
    vec3 n = normalize(gl_FrontFacing ? eye_normal : -eye_normal);
#ifdef CUT
    vec3 x = world;
    gl_FragDepth = gl_FragCoord.z;
    if (on_cap(x)) {
        n = mat3(eye_from_world) * cut.xyz;
        vec4 clip = clip_from_eye * (eye_from_world * vec4(x, 1.0));
        gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
    }
#endif
    result = vec4(0.5 + 0.5 * n, 1.0);
})glsl";

/// Distance along the viewing axis [m] from the eye map's depth; 1e30: nothing there.
inline constexpr const char* distance_of = R"glsl(
uniform sampler2D eye_depth;
uniform vec2 depth_row;         // clip z = x * eye z + y
float distance_of(float depth) { return depth < 1.0 ? depth_row.y / (2.0 * depth - 1.0 + depth_row.x) : 1e30; }
)glsl";

/// How much of the sky (R) and of the key light (G) each visible point sees. Sky: ambient obscurance (McGuire et al.
/// 2011), neighbours in a disc of world radius `reach` that rise above the tangent plane. Key: share of a small disc of
/// the light's depth map that is not in front.
inline constexpr const char* visibility_fragment = R"glsl(
in vec2 uv;
uniform sampler2D eye_normal;
uniform vec2 half_extent;       // tan of half the field of view, x and y
uniform float reach, size;
uniform vec3 key_light;         // eye space
uniform sampler2DShadow light_depth;
uniform mat4 light_from_eye;    // to texture space, 0..1
uniform float light_width;
out vec4 result;
const int sky_taps = 12, key_taps = 6;
vec3 at(vec2 p, float d) { return vec3((2.0 * p - 1.0) * half_extent * d, -d); }
float sky(vec3 x, vec3 n, float distance, vec2 way) {
    vec2 radius = 0.5 * reach / (distance * half_extent);
    float sum = 0.0, near = 1.0 / (reach * reach);
    for (int i = 0; i < sky_taps; ++i) {
        vec2 p = uv + radius * spiral(i, sky_taps) * way;
        way = golden * way;
        vec3 v = at(p, distance_of(texture(eye_depth, p).r)) - x;
        float vv = dot(v, v), vn = dot(v, n) - 0.004 * size;
        float falloff = max(0.0, 1.0 - vv * near);
        sum += falloff * falloff * max(0.0, vn) * inversesqrt(vv + 1e-6 * size * size);
    }
    return max(0.0, 1.0 - 2.6 * sum / float(sky_taps));
}
float key(vec3 x, vec3 n, vec2 way) {
    float facing = dot(n, key_light);
    vec3 light = (light_from_eye * vec4(x + n * size * (0.004 + 0.012 * (1.0 - facing)), 1.0)).xyz;
    float sum = 0.0, radius = 0.014 * size / light_width;
    for (int i = 0; i < key_taps; ++i) {
        sum += texture(light_depth, vec3(light.xy + radius * spiral(i, key_taps) * way, light.z));
        way = golden * way;
    }
    return facing <= 0.0 ? 0.0 : sum / float(key_taps);
}
void main() {
    float depth = texture(eye_depth, uv).r;
    if (depth >= 1.0) discard;
    float distance = distance_of(depth);
    vec3 x = at(uv, distance), n = normalize(2.0 * texture(eye_normal, uv).xyz - 1.0);
    vec2 way = pattern();
    result = vec4(sky(x, n, distance, way), key(x, n, way), 1.0, 1.0);
})glsl";

/// Averages 4 neighbours of about the same distance along one axis; once more along the other, and the 4x4 pattern is
/// gone. Pixels just outside of the silhouette take over their neighbours' values (B tells that they have one), because
/// samples of the finer picture fall on them.
inline constexpr const char* visibility_blur_fragment = R"glsl(
in vec2 uv;
uniform sampler2D visibility;
uniform ivec2 axis;
uniform float size;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(eye_depth, 0) - 1;
    float d = distance_of(texelFetch(eye_depth, here, 0).r);
    vec3 sum = vec3(0.0);
    for (int i = -2; i < 2; ++i) {
        ivec2 p = clamp(here + i * axis, ivec2(0), last);
        float there = distance_of(texelFetch(eye_depth, p, 0).r);
        vec3 v = texelFetch(visibility, p, 0).rgb;
        sum += d > 1e29 || abs(there - d) < 0.03 * size ? v.b * vec3(v.rg, 1.0) : vec3(0.0);
    }
    result = sum.z > 0.0 ? vec4(sum.xy / sum.z, 1.0, 1.0) : vec4(1.0, 1.0, 0.0, 1.0);
})glsl";

}  // namespace tetfront::shaders
