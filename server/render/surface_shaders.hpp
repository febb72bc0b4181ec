#pragma once
// GLSL of what is in the picture: background, surface, lines.

namespace tetfront::shaders {

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

/// The front's section, as colours only.
inline constexpr const char* section_vertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 2) in vec4 colour;
uniform mat4 clip_from_world;
out vec4 paint;
void main() {
    paint = colour;
    gl_Position = clip_from_world * vec4(position, 1.0);
})glsl";
inline constexpr const char* section_fragment = R"glsl(
in vec4 paint;
out vec4 result;
void main() { result = paint; }
)glsl";

/// Soft studio light: sky and floor from all around, a key light with a soft shadow, a weak fill and a rim from behind.
inline constexpr const char* surface_fragment = R"glsl(
in vec3 world, world_normal, albedo;
#ifdef CUT
uniform sampler2D section;       // of the front, where the cut opens it
#else
uniform vec3 eye_position;
#endif
uniform vec3 up, key_light, fill_light, rim_light;   // unit vectors towards the lights
uniform mat4 clip_from_world;
uniform sampler2D visibility;    // of sky and key light, of the whole picture
uniform vec4 tile;               // scale and offset of this tile in the picture
uniform vec2 tile_samples;
out vec4 result;
void main() {
    vec3 x = world, n = normalize(world_normal), paint = albedo;
    if (!gl_FrontFacing) n = -n;
#ifdef CUT
    gl_FragDepth = gl_FragCoord.z;
    if (on_cap(x)) {
        vec4 inside = texelFetch(section, ivec2(gl_FragCoord.xy), 0);
        n = cut.xyz, paint = mix(vec3(0.52, 0.49, 0.45), decode(inside.rgb), step(0.5, inside.a));
        vec4 clip = clip_from_world * vec4(x, 1.0);
        gl_FragDepth = 0.5 + 0.5 * clip.z / clip.w;
    }
#endif
    vec3 v = normalize(eye_position - x);
    vec2 visible = texture(visibility, gl_FragCoord.xy / tile_samples * tile.xy + tile.zw).rg;
    float ambient = visible.r;
    float sky = 0.5 + 0.5 * dot(n, up), facing = dot(n, key_light);
    float key = smoothstep(0.0, 0.12, facing) * facing * visible.g;
    float fill = max(0.0, 0.6 * dot(n, fill_light) + 0.4);
    float grazing = 1.0 - max(0.0, dot(n, v)), fresnel = grazing * grazing * grazing * grazing;
    vec3 light = ambient * (mix(vec3(0.17, 0.16, 0.155), vec3(0.42, 0.44, 0.47), sky) + 0.13 * fill)
               + key * vec3(0.86, 0.83, 0.79);
    // GGX highlight of the key light, roughness 0.42, and the sky mirrored at grazing angles.
    vec3 h = normalize(key_light + v);
    float a2 = 0.031, nh = max(0.0, dot(n, h)), d = nh * nh * (a2 - 1.0) + 1.0;
    float gloss = 0.04 * a2 / (3.14159265 * d * d) * 0.9;
    float rim = fresnel * ambient * (0.16 + 0.5 * max(0.0, dot(n, rim_light)));
    vec3 c = paint * light + vec3(0.8 * gloss * key + 0.4 * rim);
    vec3 above = max(c - 0.72, 0.0);
    c = min(c, 0.72) + above * 0.28 / (0.28 + above);   // soft shoulder instead of clipping
    result = vec4(encode(c), 1.0);
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
