#version 450 core
// Rings of samples at half resolution: the background in each pixel's disc, ring by ring from the
// outside, under the foreground in the widest disc of the tiles around.
//
// Input:  half_image of half_resolution.frag (signed CoC RADIUS, px of the whole image, negative in
//         front of the focus), levels of half_resolution_halved.frag above it, tiles of
//         half_resolution_tiles.frag, dilated.
// Output: rgb times opacity, and opacity.
//
//      . . . .          8 k samples on ring k, and the centre; they are read where texels are about as
//     . . . . .         wide as the gaps between rings, and shifted by up to half a gap at random. A
//      . . . .          sample weighs 1 / area of its own disc.
//
// Background: a ring in whose discs the rings outside would be hidden takes weight from those.
// Foreground: two samples opposite each other have the radius of the nearer; what is at least 2 px
//         narrower than the widest disc is a layer behind the rest.
// NumPy twin: tests/oracles/half_resolution.py. As the gather of Filament's depth of field (after
// Jimenez 2014 and Abadie 2018).
#include "eyes.glsl"
#include "mixed.glsl"

uniform eye_image half_image;
uniform eye_image levels[CHAIN];
uniform eye_image tiles;
uniform float pixel_aspect_of_eye[EYES];   // image pixels per unit, vertical / horizontal
float pixel_aspect = pixel_aspect_of_eye[EYE];

out vec4 blurred;

const float TURN = 6.28318531;
const float ALIKE = 0.05;  // part by which radii of a fast tile may differ, as in the source
const float GAPS = float(RINGS) - 0.5;   // radius of a disc over the distance of rings
const float SAMPLES = float((2 * RINGS - 1) * (2 * RINGS - 1));
// Keeps weights near 1; the opacity of the background is nearly always full with it.
const float UNIT_AREA_PX2 = 1024.0;

ivec2 last = size_of(half_image) - 1;

struct Sum {
    vec3 colour;
    float weight, radius_px;
};

Sum added(Sum sum, float weight, vec3 colour, float radius_px) {
    return Sum(sum.colour + weight * colour, sum.weight + weight, sum.radius_px + weight * radius_px);
}

// Level whose texels are as wide as the gaps between rings.
int level_of(float kernel_px) {
    return clamp(int(floor(log2(max(0.5 * kernel_px / GAPS, 1.0)) + 0.5)), 0, CHAIN);
}

vec4 texel_at(vec2 texels, int level) {
    ivec2 texel = ivec2(clamp(floor(texels), vec2(0.0), vec2(last)));
    if (level == 0)
        return texel_of(half_image, texel);
    // Samplers in an array may be chosen by nothing that differs between pixels.
    vec4 found = vec4(0.0);
    for (int k = 1; k <= CHAIN; ++k)
        if (k == level)
            found = texel_of(levels[k - 1], texel >> k);
    return found;
}

vec3 smooth_at(vec2 texels, int level) {
    vec3 found = vec3(0.0);
    if (level == 0)
        found = filtered_at(half_image, texels / vec2(size_of(half_image))).rgb;
    for (int k = 1; k <= CHAIN; ++k)
        if (k == level)
            found = filtered_at(levels[k - 1], texels * exp2(-float(k)) / vec2(size_of(levels[k - 1]))).rgb;
    return found;
}

vec2 on_ring(int ring, int i, float kernel_px) {
    float angle = TURN * (float(i) + 0.5 * float(ring & 1)) / float(8 * ring);
    return kernel_px * float(ring) / GAPS * vec2(cos(angle), sin(angle));
}

vec2 texels_of(vec2 away_px) {
    return 0.5 * away_px * vec2(1.0, pixel_aspect);
}

// Weight of a disc, by its area; none is smaller than a texel.
float share(float radius_px, int level) {
    return UNIT_AREA_PX2 / max(radius_px * radius_px, 2.0 * exp2(float(level)));
}

float weight_of(float radius_px, float distance_px, int level) {
    float reaches = clamp((radius_px - distance_px) * exp2(-float(level)) + 0.5, 0.0, 1.0);
    return reaches * share(radius_px, level);
}

// All discs of the tile are about as wide: nothing is compared.
vec4 alike(float kernel_px, vec2 noise) {
    int level = level_of(kernel_px);
    vec2 centre = gl_FragCoord.xy + texels_of(kernel_px * noise);
    vec3 sum = smooth_at(centre, level);
    for (int ring = 1; ring < RINGS; ++ring)
        for (int i = 0; i < 8 * ring; ++i)
            sum += smooth_at(centre + texels_of(on_ring(ring, i, kernel_px)), level);
    float opacity = clamp(kernel_px - IN_FOCUS_PX, 0.0, 1.0);
    return vec4(sum / SAMPLES * opacity, opacity);
}

vec4 background(float kernel_px, vec2 noise) {
    if (kernel_px <= IN_FOCUS_PX)
        return vec4(0.0);
    int level = level_of(kernel_px);
    vec2 centre = gl_FragCoord.xy + texels_of(kernel_px * noise);
    Sum outside = Sum(vec3(0.0), 0.0, 0.0);
    for (int ring = RINGS - 1; ring >= 0; --ring) {
        int count = max(8 * ring, 1);
        float border_px = kernel_px / GAPS * (float(ring) + 0.5);
        vec2 first = ring == 0 ? vec2(0.0) : on_ring(ring, 0, kernel_px);
        float distance_px = length(first + kernel_px * noise);
        Sum here = Sum(vec3(0.0), 0.0, 0.0);
        float wider = 0.0;
        for (int i = 0; i < count; ++i) {
            vec2 away_px = ring == 0 ? vec2(0.0) : on_ring(ring, i, kernel_px);
            vec4 tap = texel_at(centre + texels_of(away_px), level);
            float weight = tap.a > 0.0 ? weight_of(tap.a, distance_px, level) : 0.0;
            // A disc that is wider than the ring belongs to the rings outside.
            float of_outside = ring == RINGS - 1 ? 1.0 : clamp(abs(tap.a) - border_px + 0.5, 0.0, 1.0);
            outside = added(outside, weight * of_outside, tap.rgb, tap.a);
            here = added(here, weight * (1.0 - of_outside), tap.rgb, tap.a);
            wider += of_outside;
        }
        if (here.weight <= 0.0)
            continue;
        float keeps = 0.0;
        if (outside.weight > 0.0) {
            float step_px = outside.radius_px / outside.weight - here.radius_px / here.weight;
            keeps = 1.0 - (1.0 - wider / float(count)) * clamp(step_px, 0.0, 1.0);
        }
        outside = Sum(keeps * outside.colour + here.colour, keeps * outside.weight + here.weight,
                      keeps * outside.radius_px + here.radius_px);
    }
    if (outside.weight <= 0.0)
        return vec4(0.0);
    float opacity = clamp(outside.radius_px - IN_FOCUS_PX, 0.0, 1.0);
    opacity *= smoothstep(IN_FOCUS_PX, 2.0, kernel_px);
    return vec4(outside.colour / outside.weight, 1.0) * opacity;
}

vec4 foreground(float kernel_px, vec2 noise) {
    int level = level_of(kernel_px);
    vec2 centre = gl_FragCoord.xy + texels_of(kernel_px * noise);
    vec4 front = vec4(0.0), back = vec4(0.0);
    for (int ring = 0; ring < RINGS; ++ring) {
        vec2 first = ring == 0 ? vec2(0.0) : on_ring(ring, 0, kernel_px);
        float distance_px = ring == 0 ? 0.0 : length(first + kernel_px * noise);
        for (int i = 0; i < max(4 * ring, 1); ++i) {
            vec2 away_px = ring == 0 ? vec2(0.0) : on_ring(ring, i, kernel_px);
            vec4 tap = texel_at(centre + texels_of(away_px), level);
            vec4 pair = vec4(tap.rgb, 1.0);
            float radius_px = tap.a;
            if (ring > 0) {
                vec4 opposite = texel_at(centre - texels_of(away_px), level);
                pair += vec4(opposite.rgb, 1.0);
                radius_px = min(radius_px, opposite.a);
            }
            float weight = clamp(-radius_px, 0.0, 1.0) * weight_of(-radius_px, distance_px, level);
            float behind = clamp(0.5 * (radius_px + kernel_px - 2.0), 0.0, 1.0);
            front += weight * (1.0 - behind) * pair;
            back += weight * behind * pair;
        }
    }
    float full = SAMPLES * share(kernel_px * (float(RINGS) + 0.5) / float(RINGS), level);
    vec2 opacity = clamp(vec2(front.a, back.a) / full, 0.0, 1.0);
    vec3 colour = front.a > 0.0 ? front.rgb / front.a * opacity.x : vec3(0.0);
    if (back.a > 0.0)
        colour += back.rgb / back.a * opacity.y * (1.0 - opacity.x);
    return vec4(colour, 1.0 - (1.0 - opacity.x) * (1.0 - opacity.y));
}

void main() {
    vec2 radii_px = texel_of(tiles, ivec2(gl_FragCoord.xy) / TILE).rg;
    if (max(abs(radii_px.r), abs(radii_px.g)) < IN_FOCUS_PX) {
        blurred = vec4(0.0);
        return;
    }
    uvec2 place = uvec2(gl_FragCoord.xy);
    uint one = mixed(place.x ^ mixed(place.y)), other = mixed(one);
    float angle = TURN * float(one) / 4294967296.0;
    vec2 noise = 0.5 / GAPS * sqrt(float(other) / 4294967296.0) * vec2(cos(angle), sin(angle));
    if (radii_px.g - radii_px.r <= ALIKE * abs(radii_px.g)) {
        blurred = alike(0.5 * (abs(radii_px.r) + abs(radii_px.g)), noise);
        return;
    }
    vec4 back = vec4(0.0), front = vec4(0.0);
    if (radii_px.r < 0.0)
        front = foreground(-radii_px.r, noise);
    if (radii_px.g > 0.0)
        back = background(abs(texel_of(half_image, ivec2(gl_FragCoord.xy)).a), noise);
    blurred = min(front + (1.0 - front.a) * back, HALF_MAX);
}
