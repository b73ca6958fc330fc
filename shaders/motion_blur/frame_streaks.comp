#version 450 core
// The streaks of a whole frame, from those of its tiles: one work group of each eye.
//
// Input:  tile_max (tile_max.frag); max_radius_px.
// Output: frame, 1x1: x = longest half velocity, px, without the limit; y = steepness of the steepest tile;
//         z = length of the shortest half velocity; w = how the frame is averaged (frame_kinds.glsl).
//         longest_of_all, 1x1: the longest half velocity of all frames.
// Half velocities are RADII, px: a point spreads from -u to +u around where it is drawn.
// Source: ours. Positive floats have the order of their bits, so that integers find maximum and minimum.
#define EYE int(gl_WorkGroupID.z)
#include "eyes.glsl"
#include "velocity.glsl"
#include "frame_kinds.glsl"
#include "summed_texels.glsl"
layout(local_size_x = 1024) in;  // as many as every OpenGL 4.5 has

uniform eye_image tile_max;
uniform float max_radius_px;
layout(rgba32f, binding = 0) uniform writeonly stored_eye_image frame;
layout(r32f, binding = 1) uniform stored_eye_image longest_of_all;

shared uint longest, steepest, shortest;
shared uint widest_slope[2];  // greatest |y| / |x| and |x| / |y|

uint bits(float positive) {
    return floatBitsToUint(positive);
}

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        longest = steepest = widest_slope[0] = widest_slope[1] = 0u;
        shortest = bits(1e30);
    }
    barrier();
    ivec2 size = size_of(tile_max);
    vec4 most = vec4(0.0);
    float least = 1e30;
    int last = texels_of(size);
    for (int i = int(gl_LocalInvocationIndex); i < last; i += int(gl_WorkGroupSize.x)) {
        vec4 tile = texel_of(tile_max, texel_at(i, size));
        vec2 extent = abs(tile.xy);
        most = max(most, vec4(length(extent), tile.w, extent.yx / max(extent, 1e-6)));
        least = min(least, tile.z);
    }
    atomicMax(longest, bits(most.x));
    atomicMax(steepest, bits(most.y));
    atomicMin(shortest, bits(least));
    atomicMax(widest_slope[0], bits(most.z));
    atomicMax(widest_slope[1], bits(most.w));
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        vec3 found = uintBitsToFloat(uvec3(longest, steepest, shortest));
        vec2 slopes = uintBitsToFloat(uvec2(widest_slope[0], widest_slope[1]));
        vec2 range = min(found.zx, max_radius_px);
        imageStore(frame, texel_of_eye(ivec2(0)), vec4(found, kind_of(range.x, range.y, slopes)));
        float before = imageLoad(longest_of_all, texel_of_eye(ivec2(0))).x;
        imageStore(longest_of_all, texel_of_eye(ivec2(0)), vec4(max(before, found.x)));
    }
}
