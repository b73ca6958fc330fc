#version 450 core
// Wide discs of one surface, at half resolution.
//
// Input:  half_resolution (downsample.frag) with its mip chain, read trilinearly; dilated
//         (coc_tile_dilate.frag).
// Output: rgb where a disc is drawn here; else as it was.
//
// Half resolution and its enlargement blur by themselves: the discs are narrower by that variance.
#include "coc.glsl"
#include "discs.glsl"
#include "footprint.glsl"
#include "levels.glsl"

uniform sampler2D half_resolution;

out vec4 gathered;

const float HALF_VARIANCE_PX2 = 1.0;

void main() {
    gathered = texelFetch(half_resolution, ivec2(gl_FragCoord.xy), 0);
    float radius = abs(gathered.a);
    bool wanted = radius >= 0.9 * FADED * EXACT_PX;
    float texels = 0.5 * sqrt(max(radius * radius - 4.0 * HALF_VARIANCE_PX2, 0.0));
    vec2 at = gl_FragCoord.xy / vec2(textureSize(half_resolution, 0));
    gathered.rgb = mean_over(half_resolution, at, gathered.rgb, texels, wanted);
}
