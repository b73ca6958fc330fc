#version 450 core
// How near a thing may be to belong to what lies behind near things, on corners of tiles.
//
// Input:  focus (include/coc_of_depth.glsl); size_px of the image.
// Output: the reverse-Z depth at which the RADIUS is -BEHIND_PX; above 1 where no depth's is.
//
// By halving: any law, with peripheral blur or along each ray, is monotonic in depth. Between corners
// of tiles of 8 px it is linear, or nearly so.
#include "eyes.glsl"
#include "coc.glsl"
#include "coc_of_depth.glsl"
#include "near.glsl"

uniform vec2 size_px;

out float limit;

void main() {
    vec2 at = floor(gl_FragCoord.xy) * float(TILE) / size_px;
    float farther = 0.0, nearer = 2.0;
    for (int i = 0; i < 32; ++i) {
        float middle = 0.5 * (farther + nearer);
        bool is_near = radius_at(middle, at) < -BEHIND_PX;
        nearer = is_near ? middle : nearer;
        farther = is_near ? farther : middle;
    }
    limit = nearer;
}
