#version 450 core
// The depth of what is seen, along columns: after seen_depth_rows.frag, which says what its inputs mean.
//
// Input:  rows (x = depth, y = radius in pixels of image width), max_radius_px (r_max, a RADIUS),
//         pixel_aspect (vertical over horizontal px per radian). TAPS: of each side, at most.
// Output: depth, reverse-Z.
// Twin: tests/oracles/seen_depth.py.
#include "eyes.glsl"
uniform eye_image rows;
uniform float max_radius_px_of_eye[EYES];
float max_radius_px = max_radius_px_of_eye[EYE];
uniform float pixel_aspect_of_eye[EYES];
float pixel_aspect = pixel_aspect_of_eye[EYE];

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int size = size_of(rows).y;
    int reach = int(ceil(max_radius_px * pixel_aspect));
    int step_px = max(1, (reach + TAPS - 1) / TAPS);
    float nearest = 0.0;
    for (int offset = -TAPS * step_px; offset <= TAPS * step_px; offset += step_px) {
        int y = pixel.y + offset;
        if (y < 0 || y >= size)
            continue;
        vec2 seen = texel_of(rows, ivec2(pixel.x, y)).xy;
        if (offset == 0 || seen.y * pixel_aspect >= float(abs(offset)))
            nearest = max(nearest, seen.x);
    }
    gl_FragDepth = nearest;
}
