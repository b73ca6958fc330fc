#version 450 core
// Wide discs of one surface, at half resolution.
//
// Input:  layers of level 1, 2 … (layers.frag), of which each texel's mean is taken.
// Output: rgb of discs about the middles of texels of level 1, where they are not summed over pixels.
//
// A disc is summed on the level on which it has not too many texels; two levels share the discs
// between them. Texels blur by themselves: the discs are narrower by that variance.
#include "eyes.glsl"
#include "coc.glsl"
#include "discs.glsl"
#include "finite.glsl"
#include "levels.glsl"
#include "layers.glsl"

uniform ueye_image layers[LEVELS - 1];  // of level 1, 2, …

out vec4 gathered;

vec4 mean_of(Layers texel) {
    return mix(texel.back, texel.front, texel.coverage);
}

float own_radius = mean_of(unpack_layers(texel_of(layers[0], ivec2(gl_FragCoord.xy)))).a;
float radius_px = abs(own_radius);

// A texel at the rim comes farther than what makes a tile one surface: what is not of the disc's is left out.
vec3 colour_of(ueye_image layers, ivec2 at) {
    Layers q = unpack_layers(texel_of(layers, at));
    vec2 parts = vec2(q.coverage * (1.0 - nearer(own_radius, q.front.a)),
                      (1.0 - q.coverage) * (1.0 - nearer(q.back.a, own_radius)));
    float all = parts.x + parts.y;
    return all > 0.0 ? mix(q.back.rgb, q.front.rgb, parts.x / all) : mean_of(q).rgb;
}
#define IMAGE ueye_image
#include "footprint.glsl"

// Of a disc about a texel, centred on one, the sums of mean_over are wider than a disc: about a tenth in
// variance. This takes it back, to about 0.1 px^2.
const float TOO_WIDE_AT = 1.12;      // Fitted: python -m bench --only fitted
const float TOO_WIDE_WITHIN = 0.33;  // Fitted: python -m bench --only fitted
const float TOO_WIDE_BY = 0.16;      // Fitted: python -m bench --only fitted

float centred_on_texel(float texels) {
    float about = (texels - TOO_WIDE_AT) / TOO_WIDE_WITHIN;
    return texels - TOO_WIDE_BY * max(1.0 - about * about, 0.0);
}

const float NEIGHBOURS = 0.9;  // pixels read between texels: one beside a disc that is wanted may be narrower
bool wanted = radius_px >= NEIGHBOURS * FADED * EXACT_PX;

void gather(ueye_image image, int level) {
    // What is shared with the pixels counts in full: fast.frag mixes.
    float part = level > 1 ? level_part(level, radius_px) : 1.0 - coarser_part(1, radius_px);
    float texel_px = float(1 << level);
    float texels = disc_texels(sqrt(max(radius_px * radius_px - ENLARGED_PX2, 0.0)), texel_px);
    texels = level == 1 ? centred_on_texel(texels) : texels;
    vec2 place = 2.0 * gl_FragCoord.xy / texel_px - 0.5;
    vec3 mean = mean_over(image, place, texels, wanted && part > 0.0);
    gathered.rgb += part > 0.0 ? part * mean : vec3(0.0);
}

void main() {
    gathered = vec4(0.0, 0.0, 0.0, 1.0);
#define GATHER(level) gather(layers[level - 1], level);
    EACH_COARSER_LEVEL(GATHER)
}
