#version 450 core
// A triangle that covers the image, in frames with LONG streaks or, without LONG, in the others.
//
// Input:  gl_VertexID 0, 1, 2; frame_longest = the longest half velocity of the frame, px; SHORT_PX, up
//         to which half velocities are averaged in one step.
// Output: gl_Position; the triangle has no area where it is not to be drawn.
uniform sampler2D frame_longest;

void main() {
    bool is_long = texelFetch(frame_longest, ivec2(0), 0).r > SHORT_PX;
#ifdef LONG
    bool drawn = is_long;
#else
    bool drawn = !is_long;
#endif
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(drawn ? 2.0 * corner - 1.0 : vec2(-2.0), 0.0, 1.0);
}
