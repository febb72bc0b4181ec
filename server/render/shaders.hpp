#pragma once
// The renderer's GLSL. Everything is computed in linear light and world space [m]; only what goes into the picture is
// sRGB-encoded, with premultiplied alpha. `size` is a length of the object [m] that scales all distances.

namespace tetfront::shaders {

inline constexpr const char* version = "#version 330 core\n";

/// One triangle that covers the viewport; no vertex buffer.
inline constexpr const char* full_screen_vertex = R"glsl(
out vec2 uv;
void main() {
    uv = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
})glsl";

inline constexpr const char* common = R"glsl(
const float pi = 3.14159265;
// i-th of n points that fill the unit disc evenly (Vogel's spiral).
vec2 disc(int i, int n, float turn) {
    float angle = 2.39996323 * float(i) + turn;
    return sqrt((float(i) + 0.5) / float(n)) * vec2(cos(angle), sin(angle));
}
float encode(float x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055; }
vec3 encode(vec3 c) { return vec3(encode(c.r), encode(c.g), encode(c.b)); }
float decode(float x) { return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4); }
vec3 decode(vec3 c) { return vec3(decode(c.r), decode(c.g), decode(c.b)); }
)glsl";

/// The view's cut, `cut` = (normal, normal . point) or zeros: what lies beyond is clipped. Where the object's inner side
/// shows through the opening, the point of the plane before it takes its place, so that a closed surface looks solid.
inline constexpr const char* cut_vertex = R"glsl(
uniform vec4 cut;
float kept(vec3 position) { return cut.w - dot(cut.xyz, position); }
)glsl";
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

/// Depth only, seen by a light.
inline constexpr const char* depth_vertex = R"glsl(
layout(location = 0) in vec3 position;
uniform mat4 clip_from_world;
void main() {
    gl_ClipDistance[0] = kept(position);
    gl_Position = clip_from_world * vec4(position, 1.0);
})glsl";
inline constexpr const char* depth_fragment = "void main() {}\n";

/// Eye-space normal and distance along the viewing axis, for ambient occlusion. Distance 0: nothing there.
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
inline constexpr const char* eye_fragment = R"glsl(
in vec3 world, eye_normal;
uniform mat4 eye_from_world;
out vec4 result;
void main() {
    vec3 x = world;
    vec3 n = on_cap(x) ? mat3(eye_from_world) * cut.xyz : normalize(gl_FrontFacing ? eye_normal : -eye_normal);
    result = vec4(n, -(eye_from_world * vec4(x, 1.0)).z);
})glsl";

/// How much of the sky (R) and of the key light (G) each visible point sees. Sky: ambient obscurance (McGuire et al.
/// 2011), neighbours in a disc of world radius `reach` that rise above the tangent plane. Key: share of a small disc of
/// the light's depth map that is not in front. Spirals are turned in a 4x4 pattern that the blur below averages out.
inline constexpr const char* visibility_fragment = R"glsl(
in vec2 uv;
uniform sampler2D eye;          // normal, distance
uniform vec2 half_extent;       // tan of half the field of view, x and y
uniform float reach, size;
uniform vec3 key_light;         // eye space
uniform sampler2DShadow light_depth;
uniform mat4 light_from_eye;    // to texture space, 0..1
uniform float light_width;
out vec4 result;
const int sky_taps = 14, key_taps = 8;
vec3 at(vec2 p, float d) { return vec3((2.0 * p - 1.0) * half_extent * d, -d); }
float sky(vec3 x, vec3 n, float distance, float turn) {
    vec2 radius = 0.5 * reach / (distance * half_extent);
    float sum = 0.0;
    for (int i = 0; i < sky_taps; ++i) {
        vec2 p = uv + radius * disc(i, sky_taps, turn);
        float d = texture(eye, p).w;
        vec3 v = at(p, d) - x;
        float vv = dot(v, v), vn = dot(v, n) - 0.004 * size;
        float falloff = d > 0.0 ? max(0.0, 1.0 - vv / (reach * reach)) : 0.0;
        sum += falloff * falloff * max(0.0, vn) * inversesqrt(vv + 1e-6 * size * size);
    }
    return max(0.0, 1.0 - 2.6 * sum / float(sky_taps));
}
float key(vec3 x, vec3 n, float turn) {
    float facing = dot(n, key_light);
    if (facing <= 0.0) return 0.0;
    vec3 light = (light_from_eye * vec4(x + n * size * (0.004 + 0.012 * (1.0 - facing)), 1.0)).xyz;
    float sum = 0.0, radius = 0.014 * size / light_width;
    for (int i = 0; i < key_taps; ++i)
        sum += texture(light_depth, vec3(light.xy + radius * disc(i, key_taps, turn), light.z));
    return sum / float(key_taps);
}
void main() {
    vec4 here = texture(eye, uv);
    if (here.w <= 0.0) discard;
    vec3 x = at(uv, here.w);
    ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
    float turn = float((cell.x * 5 + cell.y * 7 + (cell.x ^ cell.y) * 3) & 15) * (2.0 * pi / 16.0);
    result = vec4(sky(x, here.xyz, here.w, turn), key(x, here.xyz, turn), 0.0, 1.0);
})glsl";
/// Averages 4x4 neighbours of about the same distance. Pixels just outside of the silhouette take over their
/// neighbours' values, because samples of the finer picture fall on them.
inline constexpr const char* visibility_blur_fragment = R"glsl(
in vec2 uv;
uniform sampler2D visibility, eye;
uniform float size;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(eye, 0) - 1;
    float d = texelFetch(eye, here, 0).w;
    vec2 sum = vec2(0.0);
    float weights = 0.0;
    for (int y = -2; y < 2; ++y) {
        for (int x = -2; x < 2; ++x) {
            ivec2 p = clamp(here + ivec2(x, y), ivec2(0), last);
            float there = texelFetch(eye, p, 0).w;
            float w = there > 0.0 && (d <= 0.0 || abs(there - d) < 0.03 * size) ? 1.0 : 0.0;
            sum += w * texelFetch(visibility, p, 0).rg;
            weights += w;
        }
    }
    result = vec4(weights > 0.0 ? sum / weights : vec2(1.0), 0.0, 1.0);
})glsl";

/// Share of the sky that the object hides from the floor, in floor coordinates: the sum of form factors
/// h^2 / (pi (h^2 + r^2)^2) dA of horizontal patches at height h and distance r.
inline constexpr const char* floor_sky_fragment = R"glsl(
in vec2 uv;
uniform sampler2D height;        // of the object's underside above the floor, 0..1 of `height_range`; 1: nothing
uniform float height_range;      // [m]
uniform float floor_width;       // [m] width of the square that all floor textures cover
uniform float size;
out vec4 result;
const int taps = 72;
void main() {
    ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
    float turn = float((cell.x * 5 + cell.y * 7 + (cell.x ^ cell.y) * 3) & 15) * (2.0 * pi / 16.0);
    float reach = 0.8 * size, sky = 0.0;
    for (int i = 0; i < taps; ++i) {
        float u = (float(i) + 0.5) / float(taps), r = reach * u, angle = 2.39996323 * float(i) + turn;
        float h = texture(height, uv + r / floor_width * vec2(cos(angle), sin(angle))).r;
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
const int search_taps = 12, shadow_taps = 24;
const float spread = 0.12;       // diameter over distance of the light: an area light, seen under 7 degrees
float key_shadow(vec3 light) {
    float search = spread * 0.5 * size / light_width, limit = min(light.z, 1.0);
    if (any(lessThan(light.xy, vec2(-search))) || any(greaterThan(light.xy, vec2(1.0 + search)))) return 0.0;
    float depth = 0.0, blockers = 0.0;
    for (int i = 0; i < search_taps; ++i) {
        float d = texture(light_depth, light.xy + search * disc(i, search_taps, 0.0)).r;
        float blocks = d < limit ? 1.0 : 0.0;
        depth += blocks * d, blockers += blocks;
    }
    if (blockers == 0.0) return 0.0;
    float gap = (light.z - depth / blockers) * light_width;
    float radius = max(spread * gap, 0.008 * size) / light_width, key = 0.0;
    for (int i = 0; i < shadow_taps; ++i)
        key += texture(light_depth, light.xy + radius * disc(i, shadow_taps, 0.0)).r < limit ? 1.0 : 0.0;
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

inline constexpr const char* background_fragment = R"glsl(
in vec2 uv;
uniform vec3 top, bottom;        // encoded
uniform vec4 tile;               // scale and offset of this tile in the picture
out vec4 result;
void main() {
    vec2 p = uv * tile.xy + tile.zw;
    result = vec4(mix(bottom, top, smoothstep(0.0, 1.0, p.y)), 1.0);
})glsl";

inline constexpr const char* surface_vertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
uniform mat4 clip_from_world;
out vec3 world, world_normal, albedo;
void main() {
    world = position;
    world_normal = normal;
    albedo = decode(colour.rgb);
    gl_ClipDistance[0] = kept(position);
    gl_Position = clip_from_world * vec4(position, 1.0);
})glsl";

/// Soft studio light: sky and floor from all around, a key light with a soft shadow, a weak fill and a rim from behind.
inline constexpr const char* surface_fragment = R"glsl(
in vec3 world, world_normal, albedo;
uniform vec3 up, key_light, fill_light, rim_light;   // unit vectors towards the lights
uniform mat4 clip_from_world;
uniform sampler2D visibility;    // of sky and key light, of the whole picture
uniform vec4 tile;               // scale and offset of this tile in the picture
uniform vec2 tile_samples;
out vec4 result;
void main() {
    vec3 x = world, n = normalize(world_normal), paint = albedo;
    if (!gl_FrontFacing) n = -n;
    gl_FragDepth = gl_FragCoord.z;
    if (on_cap(x)) {
        n = cut.xyz, paint = vec3(0.52, 0.49, 0.45);
        vec4 clip = clip_from_world * vec4(x, 1.0);
        gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
    }
    vec3 v = normalize(eye_position - x);
    vec2 visible = texture(visibility, gl_FragCoord.xy / tile_samples * tile.xy + tile.zw).rg;
    float ambient = visible.r;
    float sky = 0.5 + 0.5 * dot(n, up), facing = dot(n, key_light);
    float key = smoothstep(0.0, 0.12, facing) * facing * visible.g;
    float fill = max(0.0, 0.6 * dot(n, fill_light) + 0.4);
    float fresnel = pow(1.0 - max(0.0, dot(n, v)), 4.0);
    vec3 light = ambient * (mix(vec3(0.17, 0.16, 0.155), vec3(0.42, 0.44, 0.47), sky) + 0.13 * fill)
               + key * vec3(0.86, 0.83, 0.79);
    // GGX highlight of the key light, roughness 0.42, and the sky mirrored at grazing angles.
    vec3 h = normalize(key_light + v);
    float a2 = 0.031, nh = max(0.0, dot(n, h)), d = nh * nh * (a2 - 1.0) + 1.0;
    float gloss = 0.04 * a2 / (pi * d * d) * 0.9;
    float rim = fresnel * ambient * (0.16 + 0.5 * max(0.0, dot(n, rim_light)));
    vec3 c = paint * light + vec3(0.8 * gloss * key + 0.4 * rim);
    c = mix(c, 0.72 + 0.28 * (1.0 - exp((0.72 - c) / 0.28)), step(0.72, c));   // soft shoulder instead of clipping
    result = vec4(encode(clamp(c, 0.0, 1.0)), 1.0);
})glsl";

/// Segments as quads of constant width on the screen, one instance each. Corner 0..3 of a triangle strip.
inline constexpr const char* line_vertex = R"glsl(
layout(location = 0) in vec3 a;
layout(location = 1) in vec3 b;
layout(location = 2) in vec4 colour;
uniform mat4 clip_from_world;
uniform vec2 tile_samples;
uniform float half_width;        // [samples]
uniform vec3 eye;
uniform float bias;              // [m] towards the eye, so that edges on the surface are not half buried in it
uniform float near_plane;
uniform vec2 fade;               // eye distances: opaque before the first, weakest after the second
out float across;                // [samples] from the segment's middle
out vec4 ink;
void main() {
    vec4 p = clip_from_world * vec4(a + bias * normalize(eye - a), 1.0);
    vec4 q = clip_from_world * vec4(b + bias * normalize(eye - b), 1.0);
    // Behind the eye the division below means nothing: cut at the near plane (w is the distance along the axis).
    if (p.w < near_plane) p = mix(p, q, (near_plane - p.w) / max(q.w - p.w, 1e-9));
    else if (q.w < near_plane) q = mix(q, p, (near_plane - q.w) / max(p.w - q.w, 1e-9));
    vec2 s = p.xy / p.w * 0.5 * tile_samples, t = q.xy / q.w * 0.5 * tile_samples;
    vec2 way = t - s;
    float len = length(way);
    way = len > 1e-6 ? way / len : vec2(1.0, 0.0);
    vec4 end = (gl_VertexID & 1) == 0 ? p : q;
    float reach = half_width + 1.0;
    gl_ClipDistance[0] = kept((gl_VertexID & 1) == 0 ? a : b);
    across = (gl_VertexID & 2) == 0 ? -reach : reach;
    vec2 offset = (vec2(-way.y, way.x) * across + ((gl_VertexID & 1) == 0 ? -way : way) * 0.5 * half_width);
    ink = vec4(colour.rgb, colour.a * mix(1.0, 0.25, smoothstep(fade.x, fade.y, end.w)));
    end.xy += offset / (0.5 * tile_samples) * end.w;
    gl_Position = end;
})glsl";
inline constexpr const char* line_fragment = R"glsl(
in float across;
in vec4 ink;
uniform float half_width;
out vec4 result;
void main() {
    float alpha = ink.a * clamp(half_width + 0.5 - abs(across), 0.0, 1.0);
    result = vec4(ink.rgb * alpha, alpha);
})glsl";

}  // namespace tetfront::shaders
