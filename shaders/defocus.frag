#version 450 core
// Puts the circle of confusion beside the colour, so that one fetch gives a tap all it needs.
//
// Input:  colour (linear HDR), depth (reverse-Z, 0 = sky), focus (1x1, x = focus distance in m).
// Output: rgb = colour, finite; a = signed CoC RADIUS in pixels of image width, negative in front
//         of the focus. Full resolution; a half float holds 11 px to 1/256 px.
#include "coc.glsl"

uniform sampler2D colour;
uniform sampler2D depth;
uniform sampler2D focus;
uniform vec4 tangents;              // of the frustum: left, right, up, down
uniform vec3 head_forward_in_view;
uniform float near_m;
uniform float offset_m;             // the eye is this far in front of the head centre
uniform float infinity_m;
uniform float px_per_defocus;       // r_max over the defocus that reaches it
uniform float radius_limit_px;      // r_max

in vec2 uv;
out vec4 point;

const float HALF_MAX = 65504.0;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 c = texelFetch(colour, pixel, 0).rgb;
    point.rgb = clamp(mix(c, vec3(0.0), isnan(c)), 0.0, HALF_MAX);
    point.a = signed_radius_px(texelFetch(depth, pixel, 0).r,
                               near_m * head_depth_slope(tangents, head_forward_in_view, uv),
                               texelFetch(focus, ivec2(0), 0).x, offset_m, infinity_m,
                               px_per_defocus, radius_limit_px);
}
