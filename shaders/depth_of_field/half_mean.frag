#version 450 core
// The mean over each texel's disc, where no depth discontinuity is within reach.
//
// Input:  surfaces (half_surfaces.frag; signed CoC RADIUS, px of image width), each half as large as the one
//         before. LEVELS, EACH_LEVEL(f), TEXELS_PER_PX: as for half_gather.frag.
// Output: as half_gather.frag writes texels that nothing covers: rgb = light of the disc, a = 0; a = -1 where discs
//         are summed from pixels.
#include "eyes.glsl"
#include "coc.glsl"
#include "discs.glsl"
#include "finite.glsl"
#include "half_coverage.glsl"
#include "half_levels.glsl"

uniform eye_image surfaces[LEVELS];

out vec4 gathered;

vec3 colour_of(eye_image image, ivec2 at) {
    return texel_of(image, at).rgb;
}
#define IMAGE eye_image
#include "footprint.glsl"

vec3 light = vec3(0.0);

// The part of the disc that is summed on this level.
void gather(eye_image image, int level, float own_px, bool wanted) {
    float texel_px = float(2 << level);
    float part = wanted ? half_level_part(level, own_px) : 0.0;
    vec2 place = 2.0 * gl_FragCoord.xy / texel_px - 0.5;
    light += part * mean_over(image, place, disc_texels(narrowed_px(own_px, texel_px), texel_px), part > 0.0);
}

void main() {
    float own = texel_of(surfaces[0], ivec2(gl_FragCoord.xy)).a;
    bool wanted = !is_small(own) || abs(own) >= SMALL_FROM_PX;
#define GATHER(level) gather(surfaces[level], level, abs(own), wanted);
    EACH_LEVEL(GATHER)
    gathered = vec4(min(UP * light, HALF_MAX), wanted ? 0.0 : -1.0);
}
