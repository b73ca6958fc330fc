#version 450 core
// To which tiles the discs of lamps behind the focus come, of those that discs of near things come to.
//
// Input:  lamps (lamp_tiles.frag); drawn on tiles of class NEAR. COARSEST_PX: a disc that is drawn about the middle
//         of a coarse texel, with a rim as wide as one, comes so much farther at most.
// Output: the widest RADIUS (px) of something near that may cut them, 0 where none comes.
#include "eyes.glsl"
#include "tile_dilate.glsl"

flat in vec4 tile;  // near_tiles.frag

uniform eye_image lamps;

out float near_px;

void main() {
    ivec2 middle = ivec2(gl_FragCoord.xy), last = size_of(lamps) - 1;
    int around = tiles_around() + int(COARSEST_PX) / TILE + 1;
    bool comes = false;
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            float lamp_px = texel_of(lamps, clamp(middle + ivec2(x, y), ivec2(0), last)).r;
            comes = comes || lamp_px > 0.5 && reaches(gap_px(ivec2(x, y)), vec4(lamp_px + COARSEST_PX));
        }
    near_px = comes ? tile.r : 0.0;
}
