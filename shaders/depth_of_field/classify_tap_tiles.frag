#version 450 core
// What may reach each tile, and the class of work that it takes: the range of radii over the tiles
// around whose discs come as far, or that its own discs reach.
//
// Input:  tile_min_max (coc_tile_min_max.frag). Radii (px) that divide the classes: SLIGHT_PX,
//         FEW_PX, WIDE_PX,
//         WIDEST_PX, APART_PX. FINE_READS: whether there are programs for FINE.
// Output: r, g = least and greatest signed RADIUS (px of image width, negative in front of the focus)
//         that may matter in the tile; b = class (vrcomfort/optics/tile_classes.py).
#include "tile_dilate.glsl"

uniform sampler2D tile_min_max;

out vec4 dilated;

// Part of the widest radius by which those of one tile's surroundings may differ.
const float MOST_SPREAD = 0.5;

// What is drawn at half resolution is as blurred as a disc of this radius (px), at least.
const float LEAST_WIDE = 1.75;

int class_of(vec2 range) {
    float widest = max(abs(range.r), abs(range.g));
    float least = min(abs(range.r), abs(range.g));
    if (widest <= 0.5)
        return SHARP;
    if (widest <= SLIGHT_PX)
        return FEW;
    bool alike = range.g - range.r <= MOST_SPREAD * widest && max(range.r, -range.g) > 0.5;
    int mixed = widest > APART_PX ? APART : MIXED;
    if (!alike)
        return mixed;
    if (least > LEAST_WIDE && least + widest > 2.0 * WIDE_PX)
        return widest > WIDEST_PX ? WIDEST : WIDE;
    if (widest <= FEW_PX)
        return FEW;
    return FINE_READS ? FINE : mixed;
}

void main() {
    ivec2 last = textureSize(tile_min_max, 0) - 1;
    ivec2 middle = ivec2(gl_FragCoord.xy);
    vec4 own = texelFetch(tile_min_max, middle, 0);
    vec2 range = vec2(1e4, -1e4);
    int around = tiles_around();
    for (int y = -around; y <= around; ++y)
        for (int x = -around; x <= around; ++x) {
            vec4 t = texelFetch(tile_min_max, clamp(middle + ivec2(x, y), ivec2(0), last), 0);
            if (matters(max(abs(x), abs(y)), own, t))
                range = vec2(min(range.r, t.r), max(range.g, t.g));
        }
    dilated = vec4(range, class_of(range), 0.0);
}
