#version 450 core
// Mixes each pixel with its luminance (Rec. 709, linear).
#include "eyes.glsl"
uniform eye_image image;
uniform float amount;

out vec4 grey;

void main() {
    vec4 colour = texel_of(image, ivec2(gl_FragCoord.xy));
    float luminance = dot(colour.rgb, vec3(0.2126, 0.7152, 0.0722));
    grey = vec4(mix(colour.rgb, vec3(luminance), amount), colour.a);
}
