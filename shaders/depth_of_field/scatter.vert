#version 450 core
// A square for each pixel, as wide as its disc: a point, or where a driver's points are too small for
// the widest disc (SQUARES), an instance of a triangle strip of four corners.
//
// Input:  colour_and_coc of colour_and_coc.frag; gl_VertexID counts the pixels, or gl_InstanceID
//         does and gl_VertexID
//         the corners.
// Output: what scatter.frag needs of the pixel. A RADIUS in px of image width; its sign is lost.
#define EYE eye
#include "eyes.glsl"
#include "coc.glsl"

uniform eye_image colour_and_coc;

ivec2 size_px = size_of(colour_and_coc);
#ifdef SQUARES
int index = gl_InstanceID;
vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
#else
int index = gl_VertexID;
vec2 corner = vec2(0.0);
#endif
int eye = index / (size_px.x * size_px.y);  // the pixels of the left eye come first

uniform float pixel_aspect_of_eye[EYES];  // image pixels per unit, vertical / horizontal
float pixel_aspect = pixel_aspect_of_eye[EYE];

flat out vec3 colour;
flat out vec2 centre;
flat out float radius_px;
flat out float area_px;

void main() {
    draw_in_layer();
    ivec2 pixel = ivec2(index % size_px.x, index / size_px.x % size_px.y);
    vec4 p = texel_of(colour_and_coc, pixel);
    bool sharp = abs(p.a) <= 0.5;
    colour = p.rgb;
    centre = vec2(pixel) + 0.5;
    radius_px = max(abs(p.a), 0.5);
    // A sharp pixel is its own disc, of area 1: where nothing else arrives, it stays what it is.
    area_px = sharp ? 1.0 : max(disc_area_px(radius_px, 1.0) * pixel_aspect, 1.0);
    vec2 reach_px = sharp ? vec2(0.5) : (radius_px + 0.5) * vec2(1.0, pixel_aspect);
    gl_PointSize = 2.0 * ceil(max(reach_px.x, reach_px.y) - 0.5) + 1.0;
    gl_Position = vec4((centre + corner * reach_px) / vec2(size_px) * 2.0 - 1.0, 0.0, 1.0);
}
