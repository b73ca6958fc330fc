#version 450 core
// A triangle that covers the image, in frames of one kind.
//
// Input:  corner.glsl; frame (frame_streaks.comp). Which frames: with PASSING those in which there may be velocity discontinuities, otherwise those of
//         KIND (frame_kinds.glsl).
// Output: gl_Position; the triangle has no area where it is not to be drawn.
#define EYE eye
#include "eyes.glsl"
#include "corner.glsl"
#include "velocity.glsl"
#include "motion_tile_classes.glsl"
#include "frame_kinds.glsl"

uniform eye_image frame;

bool is_drawn(vec4 streaks) {
#ifdef PASSING
    return may_be_complex(streaks.xyz);
#else
    return streaks.w == KIND;
#endif
}

void main() {
    draw_in_layer();
    bool drawn = is_drawn(texel_of(frame, ivec2(0)));
    gl_Position = vec4(drawn ? 2.0 * corner - 1.0 : vec2(-2.0), 0.0, 1.0);
}
