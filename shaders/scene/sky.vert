#version 450 core
// The sky fills what nothing was drawn on: a full-screen triangle at depth 0 (infinity).
//
// Input:  gl_VertexID, the view.
// Output: direction (world axes, not unit) of each pixel; VELOCITY and LENS: clip positions of
//         that direction.
#include "view.glsl"
out vec3 direction;
#ifdef LENS
#include "lens.glsl"
#ifdef VELOCITY
out vec4 present_clip;
out vec4 previous_clip;
#endif
#endif

vec4 clip_at_infinity(mat4 rotation, vec3 ray) {
    return clip_from_view * vec4(mat3(rotation) * ray, 0.0);
}

void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
    vec2 seen = gl_Position.xy;
#ifdef LENS
    // A pixel shows the direction that this point of the lens brings to it.
    vec4 moved = through_lens(vec4(0.0, 0.0, 0.0, 1.0), lens.xy, lens.w, lens_focus.x, lens.w,
                              lens_limit.x, lens_limit.y);
    seen -= moved.xy;
#endif
    // ndc = (P00 x + P02 z) / -z at z = -1, solved for x (and the same for y).
    vec2 tangent = (seen + vec2(clip_from_view[2][0], clip_from_view[2][1]))
                 / vec2(clip_from_view[0][0], clip_from_view[1][1]);
    direction = transpose(mat3(view_from_relative)) * vec3(tangent, -1.0);
#if defined(VELOCITY) && defined(LENS)
    present_clip = clip_at_infinity(view_from_relative, direction);
    previous_clip = clip_at_infinity(previous_view_from_relative, direction);
#endif
}
