#version 450 core
// The median of 3x3 texels, channel by channel: takes single wrong texels away.
//
// Input:  source; tiles of half_resolution_tiles.frag: where all is in focus, the output is 0.
// Output: the same.
// NumPy twin: scipy.ndimage.median_filter. As the median of Filament's depth of field.
#include "eyes.glsl"
uniform eye_image source;
uniform eye_image tiles;

out vec4 calm;

void sort(inout vec4 a, inout vec4 b) {
    vec4 low = min(a, b);
    b = max(a, b);
    a = low;
}

void main() {
    vec2 radii_px = texel_of(tiles, ivec2(gl_FragCoord.xy) / TILE).rg;
    if (max(abs(radii_px.r), abs(radii_px.g)) < IN_FOCUS_PX) {
        calm = vec4(0.0);
        return;
    }
    ivec2 last = size_of(source) - 1;
    vec4 v[9];
    for (int i = 0; i < 9; ++i) {
        ivec2 texel = ivec2(gl_FragCoord.xy) + ivec2(i % 3, i / 3) - 1;
        v[i] = texel_of(source, clamp(texel, ivec2(0), last));
    }
    // Rows in order; then the largest of the least, the middle of the middle, the least of the
    // largest; their median is that of all.
    for (int row = 0; row < 9; row += 3) {
        sort(v[row], v[row + 1]);
        sort(v[row + 1], v[row + 2]);
        sort(v[row], v[row + 1]);
    }
    vec4 low = max(v[0], max(v[3], v[6])), high = min(v[2], min(v[5], v[8]));
    vec4 middle = max(min(v[1], v[4]), min(max(v[1], v[4]), v[7]));
    calm = max(min(low, middle), min(max(low, middle), high));
}
