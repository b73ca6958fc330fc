#version 450 core
// Lights a surface: sun with shadow, hemisphere of sky and ground, lamps, air.
//
// Input:  interpolated surface, its material and textures. UNLIT: its base colour is its radiance.
// Output: linear HDR radiance, before exposure; VELOCITY: px per frame, or AS_THE_EYE
//         (include/velocity.glsl).
//         ALPHA_MASK: alpha is coverage (the samples of a pixel are switched by it).
//         BEHIND_NEAR: only what is no nearer than `nearest` says, reverse-Z depths.
#include "where.glsl"
#include "view.glsl"
#include "light.glsl"
#include "surface.glsl"
#include "material.glsl"
#include "sky.glsl"

uniform sampler2DArray base_color_images;
uniform sampler2DArray normal_images;
uniform sampler2DArray metallic_roughness_images;
uniform sampler2DArray emissive_images;
uniform sampler2DShadow shadow_map;

#ifdef BEHIND_NEAR
#define EYE int(image_size_px.z)
#include "eyes.glsl"
uniform eye_image nearest;
#endif

in vec3 relative;
in vec3 normal;
in vec2 uv;
#ifdef UV_1
in vec2 uv_1;
#else
const vec2 uv_1 = vec2(0.0);
#endif
#ifdef VERTEX_COLORS
in vec4 color;
#endif
flat in vec2 thing;
flat in int material_index;
layout(location = 0) out vec4 radiance;
#ifdef VELOCITY
#include "velocity.glsl"
in vec4 present_clip;
in vec4 previous_clip;
flat in float own_motion;
layout(location = 1) out vec2 velocity;
#endif

#include "finite.glsl"

#ifdef VELOCITY
// At the nearest of the samples that the triangle covers: where the resolve takes its depth.
vec2 own_velocity() {
    float depth = -1.0;
    vec2 found = vec2(0.0);
    // Every index is that of a sample: Mesa 22 reads beyond its table for pixels that are not drawn.
    for (int i = 0; i < gl_NumSamples; ++i) {
        vec4 now = interpolateAtSample(present_clip, i);
        vec4 before = interpolateAtSample(previous_clip, i);
        // Mesa 22 divides both by the 1/w of the centre, which may lie beyond the horizon: w < 0.
        float upright = sign(now.w), d = now.z / now.w;
        vec2 there = velocity_px(now * upright, before * upright, image_size_px.xy);
        bool nearer = (gl_SampleMaskIn[0] >> i & 1) == 1 && d > depth;
        found = nearer ? there : found;
        depth = nearer ? d : depth;
    }
    return found;
}
#endif

// Tangent frame from screen derivatives: no tangents in the vertices.
// Source: Schueler, "Normal mapping without precomputed tangents", ShaderX 5 (2006).
vec3 mapped_normal(vec3 n, vec2 at, float layer, float scale_of_map) {
    vec3 texel = texture(normal_images, vec3(at, layer)).xyz * 2.0 - 1.0;
    texel.xy *= scale_of_map;
    vec3 dx = dFdx(relative), dy = dFdy(relative);
    vec2 du = dFdx(at), dv = dFdy(at);
    vec3 across_x = cross(dy, n), across_y = cross(n, dx);
    vec3 t = across_x * du.x + across_y * dv.x;
    vec3 b = across_x * du.y + across_y * dv.y;
    float scale = inversesqrt(max(max(dot(t, t), dot(b, b)), 1e-30));
    // glTF: v grows down in the image and green points up, hence the minus.
    return normalize((t * texel.x - b * texel.y) * scale + n * max(texel.z, 1e-3));
}

// Rough enough that the highlight is no narrower than the pixel.
// Source: Tokuyoshi & Kaplanyan, "Improved geometric specular antialiasing", I3D 2019.
const float MOST_VARIANCE = 0.18;  // of the source
const float LEAST_ALPHA = 0.01;    // narrower highlights would be sparks that one eye alone sees

float filtered_alpha(float alpha, vec3 n) {
    vec3 dx = dFdx(n), dy = dFdy(n);
    float variance = 0.25 * (dot(dx, dx) + dot(dy, dy));
    return sqrt(clamp(alpha * alpha + min(2.0 * variance, MOST_VARIANCE), 0.0, 1.0));
}

#ifdef SUN
const float FADES_FROM = 0.85, FADED_AT = 0.98;  // of the way to the shadow map's rim: no line where it ends

// Share of the sun that reaches the surface: 4 bilinear comparisons, a 3 x 3 texel tent.
float sunlight(vec3 n) {
    vec3 lifted = relative + n * shadow_bias.y;
    vec3 at = (shadow_from_relative * vec4(lifted, 1.0)).xyz;
    at.z += shadow_bias.z;
    float t = 0.5 * shadow_bias.x;
    float lit = texture(shadow_map, at + vec3(-t, -t, 0.0)) + texture(shadow_map, at + vec3(t, -t, 0.0))
              + texture(shadow_map, at + vec3(-t, t, 0.0)) + texture(shadow_map, at + vec3(t, t, 0.0));
    vec2 rim = abs(at.xy * 2.0 - 1.0);
    float inside = 1.0 - smoothstep(FADES_FROM, FADED_AT, max(rim.x, rim.y));
    return mix(1.0, 0.25 * lit, inside);  // beyond the map everything is lit
}
#endif

const float DIELECTRIC = 0.04;  // glTF 2.0: reflectance at normal incidence

void main() {
    Material material = materials[material_index];
    vec4 albedo = material.base_color;
    float ambient = thing.x;
#ifdef VERTEX_COLORS
    // A pixel's centre may lie outside the triangle: what is interpolated there leaves its range,
    // and a sliver's leaves it far enough to make a spark that one eye alone sees.
    vec4 tint = clamp(color, 0.0, 1.0);
#ifdef AMBIENT_IN_ALPHA
    albedo.rgb *= tint.rgb;
    ambient *= tint.a;
#else
    albedo *= tint;
#endif
#endif
#ifdef BASE_COLOR_IMAGE
    albedo *= texture(base_color_images,
                      vec3(on_image(material, BASE_COLOR, uv, uv_1), material.layers.x));
#endif
    float coverage = 1.0;
#ifdef ALPHA_MASK
    // Steepen alpha to one pixel's width around the cut-off, so that an edge covers by its area.
    coverage = clamp((albedo.a - material.reflection.z) / max(fwidth(albedo.a), 1e-4) + 0.5, 0.0, 1.0);
#endif
#ifdef ALPHA_BLEND
    coverage = albedo.a;
#endif
    float distance_m = length(relative);
#ifdef UNLIT
    vec3 sum = albedo.rgb;
#else
    float metallic = material.reflection.x;
    float roughness = material.reflection.y;
#ifdef METALLIC_ROUGHNESS_IMAGE
    vec4 surface = texture(metallic_roughness_images,
                           vec3(on_image(material, METALLIC_ROUGHNESS, uv, uv_1), material.layers.z));
    metallic *= surface.b;
    roughness *= surface.g;
#endif
    vec3 v = -relative / max(distance_m, 1e-6);
    // A normal without a length (files have them) has no direction: such a surface faces the eye.
    vec3 n = dot(normal, normal) > 0.0 ? normalize(normal) : v;
#ifdef DOUBLE_SIDED
    n = gl_FrontFacing ? n : -n;
#endif
    vec3 smooth_normal = n;
#ifdef NORMAL_IMAGE
    n = mapped_normal(n, on_image(material, NORMAL, uv, uv_1), material.layers.y, material.emissive.a);
#endif
    float alpha = filtered_alpha(max(roughness * roughness, LEAST_ALPHA), n);
    vec3 diffuse = albedo.rgb * (1.0 - metallic);
    vec3 f0 = mix(vec3(DIELECTRIC), albedo.rgb, metallic);

    // Sky and ground: diffuse from the hemisphere around n, specular from where it mirrors.
    vec3 hemisphere = mix(ground.rgb, mix(sky_horizon.rgb, sky_zenith.rgb, 0.5), 0.5 + 0.5 * n.y);
    vec3 mirrored = mix(sky_gradient(reflect(-v, n)), hemisphere, sqrt(alpha));
    vec3 sum = ambient * (diffuse * hemisphere
             + mirrored * ambient_reflectance(f0, roughness, max(dot(n, v), 0.0)));
#ifdef SUN
    float n_l = max(dot(n, sun_direction.xyz), 0.0);
    vec3 sun = sun_irradiance.rgb * (n_l * sunlight(smooth_normal));
    sum += sun * (diffuse * INV_PI + specular(n, v, sun_direction.xyz, f0, alpha));
#endif
#ifdef LAMPS
    uint lamps = uint(thing.y + 0.5);
    while (lamps != 0u) {
        int lamp = findLSB(lamps);
        lamps &= lamps - 1u;
        vec4 place = lamp_position[lamp];
#ifdef FAR_LAMPS
        vec3 to_lamp = place.w > 0.0 ? place.xyz - relative : place.xyz;
#else
        vec3 to_lamp = place.xyz - relative;
#endif
        float range_m = length(to_lamp);
        vec3 l = to_lamp / max(range_m, 1e-4);
        float received = max(dot(n, l), 0.0);
#ifdef FAR_LAMPS
        received *= place.w > 0.0 ? lamp_falloff(range_m, place.w) : 1.0;
#else
        received *= lamp_falloff(range_m, place.w);
#endif
#ifdef CONES
        received *= cone(l, lamp_direction[lamp], lamp_intensity[lamp].a);
#endif
        sum += lamp_intensity[lamp].rgb * received
             * (diffuse * INV_PI + specular(n, v, l, f0, alpha));
    }
#endif
    vec3 glow = material.emissive.rgb;
#ifdef EMISSIVE_IMAGE
    glow *= texture(emissive_images,
                    vec3(on_image(material, EMISSIVE, uv, uv_1), material.layers.w)).rgb;
#endif
    sum += glow;
#endif
#ifdef FOG
    sum = through_air(sum, distance_m);
#endif
    // At the rim of a triangle, what vertices interpolate may leave their range.
    radiance = vec4(finite(sum), coverage);
#ifdef VELOCITY
    velocity = vec2(AS_THE_EYE, 0.0);
    WHERE (own_motion > 0.5)
        velocity = own_velocity();
#endif
    // At last: derivatives and filtered reads need all four pixels of a block.
#ifdef BEHIND_NEAR
#ifdef ALPHA_MASK
    if (coverage < 0.5)
        discard;  // one sample: it is covered or not
#endif
    if (gl_FragCoord.z > texel_of(nearest, ivec2(gl_FragCoord.xy)).r)
        discard;
#elif defined(ALPHA_MASK)
    if (coverage <= 0.0)
        discard;
#endif
}
