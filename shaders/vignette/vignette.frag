#version 450 core
// A field-of-view restrictor: covers the image outside a clear field round an axis, which is the
// head's forward axis or the gaze.
//
// Input:  image (linear HDR); tangents of the frustum: left, right, up, down; centre_from_eye
//         (rotation; the axis is its -Z); clear_rad, the RADIUS of the clear field, and feather_rad,
//         the width of the border in which the cover begins, both as angles from the axis; mean,
//         1x1, with MEAN_COLOUR.
// Output: image, or the cover: black, or the mean colour.
// NumPy twin: tests/oracles/vignette.py. Source: Fernandes & Feiner 2016.
#include "eyes.glsl"
uniform eye_image image;
uniform vec4 tangents_of_eye[EYES];
vec4 tangents = tangents_of_eye[EYE];
uniform mat3 centre_from_each_eye[EYES];
mat3 centre_from_eye = centre_from_each_eye[EYE];
uniform float clear_rad;
uniform float feather_rad;
#ifdef MEAN_COLOUR
uniform sampler2D mean;
#endif

out vec4 restricted;

void main() {
    vec2 uv = gl_FragCoord.xy / vec2(size_of(image));
    vec3 ray = centre_from_eye * vec3(mix(tangents.xw, tangents.yz, uv), -1.0);
    float angle_rad = atan(length(ray.xy), -ray.z);
    float cover = smoothstep(0.0, 1.0, (angle_rad - clear_rad) / feather_rad);
    vec4 colour = texel_of(image, ivec2(gl_FragCoord.xy));
    vec3 covered = vec3(0.0);
#ifdef MEAN_COLOUR
    covered = texelFetch(mean, ivec2(0), 0).rgb;
#endif
    restricted = vec4(cover > 0.0 ? mix(colour.rgb, covered, cover) : colour.rgb, colour.a);
}
