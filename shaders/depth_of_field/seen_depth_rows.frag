#version 450 core
// The depth of what is seen, along rows: that of the nearest thing in front of the focus whose disc
// reaches a pixel, else the pixel's own. Columns follow (seen_depth_columns.frag): discs are squares.
//
// Input:  depth (reverse-Z), focus (include/coc_of_depth.glsl). TAPS: of each side, at most.
// Output: x = depth; y = RADIUS in pixels of image width of the disc that brought it, 0 for none.
// Twin: tests/oracles/seen_depth.py.
#include "eyes.glsl"
#include "coc.glsl"
#include "coc_of_depth.glsl"

uniform eye_image depth;

out vec2 seen;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), size = size_of(depth);
    // Wide discs are sought in steps: an outline is off by less than a step.
    int reach = int(ceil(eye.max_radius_px)), step_px = max(1, (reach + TAPS - 1) / TAPS);
    seen = vec2(0.0, 0.0);
    for (int offset = -TAPS * step_px; offset <= TAPS * step_px; offset += step_px) {
        ivec2 place = ivec2(pixel.x + offset, pixel.y);
        if (place.x < 0 || place.x >= size.x)
            continue;
        float z = texel_of(depth, place).r;
        float radius = -radius_at(z, (vec2(place) + 0.5) / vec2(size));
        bool own = offset == 0;
        if (z > seen.x && (own || radius >= float(abs(offset))))
            seen = vec2(z, max(radius, 0.0));
    }
}
