#version 450 core
// The greatest length of all texels of a texture, and of all of the frames so far: one work group of each eye.
//
// Input:  texels, of which the length of VALUE (xy, z ...) counts; what is not a number counts as 0.
// Output: greatest, of this texture; greatest_of_all, that or what stands there, if that is more. Both 1x1.
// Blur:   none.
// Source: ours. Positive floats have the order of their bits, so that integers find the maximum.
#define EYE int(gl_WorkGroupID.z)
#include "eyes.glsl"
#include "summed_texels.glsl"
layout(local_size_x = 1024) in;  // as many as every OpenGL 4.5 has

uniform eye_image texels;
layout(r32f, binding = 0) uniform writeonly stored_eye_image greatest;
layout(r32f, binding = 1) uniform stored_eye_image greatest_of_all;

shared uint most_bits;

void main() {
    if (gl_LocalInvocationIndex == 0u)
        most_bits = 0u;
    barrier();
    ivec2 size = size_of(texels);
    float most = 0.0;
    int last = texels_of(size);
    for (int i = int(gl_LocalInvocationIndex); i < last; i += int(gl_WorkGroupSize.x)) {
        float value = length(texel_of(texels, texel_at(i, size)).VALUE);
        most = value > most ? value : most;
    }
    atomicMax(most_bits, floatBitsToUint(most));
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        float found = uintBitsToFloat(most_bits);
        imageStore(greatest, texel_of_eye(ivec2(0)), vec4(found));
        float before = imageLoad(greatest_of_all, texel_of_eye(ivec2(0))).x;
        imageStore(greatest_of_all, texel_of_eye(ivec2(0)), vec4(max(before, found)));
    }
}
