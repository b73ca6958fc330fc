#version 450 core
// Wide discs of one surface, at half resolution.
//
// Input:  half_resolution (downsample.frag) with its mip chain. Its RADIUS in px of image width.
// Output: rgb where a disc is drawn here; else as it was.
//
// A disc is summed on the level of the chain on which it has not too many texels; two levels share the discs
// between them. Texels blur by themselves: the discs are narrower by that variance.
// HALF_LEVELS: of the chain; HALF_EXACT: radius of the widest disc on one, in its texels.
#include "coc.glsl"
#include "discs.glsl"
#include "footprint.glsl"
#include "levels.glsl"

uniform sampler2D half_resolution;

out vec4 gathered;

// Four times what bilinear enlargement adds to the variance: 0.75 px^2, less what the rims have too little.
const float ENLARGED_PX2 = 2.0;

// Of a disc about a texel, centred on one, the sums of mean_over are wider than a disc: about a tenth in
// variance. This takes it back, to about 0.1 px^2.
float centred_on_texel(float texels) {
    float about = (texels - 1.12) / 0.33;
    return texels - 0.16 * max(1.0 - about * about, 0.0);
}

// Part of a disc that is drawn on a level of the chain or on coarser ones.
float part_from(int lod, float texels) {
    float widest = HALF_EXACT * float(1 << max(lod - 1, 0));
    return lod == 0 ? 1.0 : lod > HALF_LEVELS - 1 ? 0.0
         : clamp((texels / widest - FADED) / (1.0 - FADED), 0.0, 1.0);
}

void main() {
    gathered = texelFetch(half_resolution, ivec2(gl_FragCoord.xy), 0);
    float radius_px = abs(gathered.a);
    bool wanted = radius_px >= 0.9 * FADED * EXACT_PX;
    vec2 at = gl_FragCoord.xy / vec2(textureSize(half_resolution, 0));
    float narrower_px = sqrt(max(radius_px * radius_px - ENLARGED_PX2, 0.0));
    vec3 sum = vec3(0.0);
    for (int lod = 0; lod < HALF_LEVELS; ++lod) {
        float part = part_from(lod, 0.5 * radius_px) - part_from(lod + 1, 0.5 * radius_px);
        vec2 place = at * vec2(textureSize(half_resolution, lod)) - 0.5;
        float texels = disc_texels(narrower_px, float(2 << lod));
        texels = lod == 0 ? centred_on_texel(texels) : texels;
        vec3 mean = mean_over(half_resolution, lod, place, texels, wanted && part > 0.0);
        sum += part > 0.0 ? part * mean : vec3(0.0);
    }
    gathered.rgb = wanted ? sum : gathered.rgb;
}
