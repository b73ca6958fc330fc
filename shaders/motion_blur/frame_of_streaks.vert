#version 450 core
// A triangle that covers the image, in frames of one kind.
//
// Input:  gl_VertexID 0, 1, 2, or corner (common/fullscreen.vert); frame (frame_streaks.vert). Which frames: with PASSING those in which
//         there may be velocity discontinuities, with LONG those whose longest half velocity is above
//         ONE_STEP_PX, otherwise those where it is not.
// Output: gl_Position; the triangle has no area where it is not to be drawn.
#ifdef CORNERS
in vec2 corner;
#else
vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
#endif
#include "velocity.glsl"
#include "motion_tile_classes.glsl"

uniform sampler2D frame;

bool is_drawn(vec3 streaks) {
#if defined PASSING
    return may_be_complex(streaks);
#elif defined LONG
    return streaks.x > ONE_STEP_PX;
#else
    return streaks.x <= ONE_STEP_PX;
#endif
}

void main() {
    bool drawn = is_drawn(texelFetch(frame, ivec2(0), 0).xyz);
    gl_Position = vec4(drawn ? 2.0 * corner - 1.0 : vec2(-2.0), 0.0, 1.0);
}
