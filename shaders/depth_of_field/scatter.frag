#version 450 core
// The circular bokeh kernel M_i of a pixel, scaled by its radius, times its colour: N_i.
//
// Input:  colour, centre, RADIUS and area of the pixel's disc (scatter.vert).
// Output: rgb = colour * weight, a = weight, to be added up. The weights of a disc sum to about 1.
// NumPy twin: tests/oracles/scattering.py. Carnegie & Rhee 2015, Algorithm 1 (Fig. 3).
#include "eyes.glsl"
#include "coc.glsl"

uniform float pixel_aspect_of_eye[EYES];
float pixel_aspect = pixel_aspect_of_eye[EYE];

flat in vec3 colour;
flat in vec2 centre;
flat in float radius_px;
flat in float area_px;
out vec4 share;

void main() {
    float distance_px = length((gl_FragCoord.xy - centre) / vec2(1.0, pixel_aspect));
    share = disc_weight(distance_px, radius_px, 1.0) / area_px * vec4(colour, 1.0);
}
