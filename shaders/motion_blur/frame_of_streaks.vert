#version 450 core
// A triangle that covers the image, in frames of one kind.
//
// Input:  gl_VertexID 0, 1, 2, or corner (common/fullscreen.vert); frame (frame_streaks.comp). Which
//         frames: with PASSING those in which there may be velocity discontinuities, otherwise those of
//         KIND (frame_kinds.glsl).
// Output: gl_Position; the triangle has no area where it is not to be drawn.
#ifdef CORNERS
in vec2 corner;
#else
vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
#endif
#include "velocity.glsl"
#include "motion_tile_classes.glsl"
#include "frame_kinds.glsl"

uniform sampler2D frame;

bool is_drawn(vec4 streaks) {
#ifdef PASSING
    return may_be_complex(streaks.xyz);
#else
    return streaks.w == KIND;
#endif
}

void main() {
    bool drawn = is_drawn(texelFetch(frame, ivec2(0), 0));
    gl_Position = vec4(drawn ? 2.0 * corner - 1.0 : vec2(-2.0), 0.0, 1.0);
}
