#version 450 core
// Half of an image: of each 2x2 texels one surface, a blurred one rather than one in focus.
//
// Input:  finer: colour_and_coc (colour_and_coc.frag; signed CoC RADIUS, px of image width, negative in
//         front of the focus), or a result of this pass.
// Output: rgb = mean over the texels of that surface, a = their mean RADIUS, its last bits the part of the texel
//         that the surface covers (half_coverage.glsl), and 1 where a pixel is less blurred than SMALL_PX. Size / 2,
//         rounded up.
//
// Texels in focus hardly count: no halo, and what is blurred goes on behind them. A lamp counts by its light.
#include "eyes.glsl"
#include "coc.glsl"
#include "finite.glsl"
#include "half_coverage.glsl"

uniform eye_image finer;

const float SHARED = 0.25;
const float SHARP_WEIGHT = 0.001;  // of what is in focus, which has no part in a blur unless it is alone

out vec4 surface;

// At least that of white.
float brightness(vec3 light) {
    return max(max(light.r, light.g), max(light.b, 1.0));
}

bool has_small(float radius) {
#ifdef FROM_SURFACES
    return is_small(radius);
#else
    return abs(radius) < SMALL_PX;
#endif
}

void main() {
    ivec2 first = 2 * ivec2(gl_FragCoord.xy);
    ivec2 last = size_of(finer) - 1;
    vec4 texels[4];
    float covered[4];
    float farthest = -1e4;
    bool small = false;
    for (int i = 0; i < 4; ++i) {
        texels[i] = texel_of(finer, min(first + ivec2(i & 1, i >> 1), last));
#ifdef FROM_SURFACES
        covered[i] = coverage_of(texels[i].a);
#else
        covered[i] = 1.0;
#endif
        farthest = max(farthest, texels[i].a);
        small = small || has_small(texels[i].a);
    }
    // Surfaces that are both blurred behind the focus share a texel: thin ones would be lost. But what is much less
    // blurred, and summed from pixels, would shine in the other's disc.
    float border = min(farthest - 1.5 * margin_px(farthest), max(SHARED * farthest, 0.5));
    vec4 front = vec4(0.0), back = vec4(0.0);
    vec2 parts = vec2(0.0), coverage = vec2(0.0), light = vec2(0.0), most = vec2(SHARP_WEIGHT);
    for (int i = 0; i < 4; ++i) {
        float blurred = mix(SHARP_WEIGHT, 1.0, clamp(abs(texels[i].a) - 0.25, 0.0, 1.0));
        float weight = covered[i] * blurred;
        bool nearer = texels[i].a < border;
        vec2 which = nearer ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
        float bright = weight * brightness(texels[i].rgb);
        front += which.x * vec4(weight * texels[i].rgb, bright * texels[i].a);
        back += which.y * vec4(weight * texels[i].rgb, bright * texels[i].a);
        parts += weight * which;
        coverage += 0.25 * weight * which;
        most = max(most, blurred * which);
        light += bright * which;
    }
    bool is_front = light.x > light.y;
    vec4 mean = is_front ? front / vec4(vec3(parts.x), light.x) : back / vec4(vec3(parts.y), light.y);
    // The rest counts as all of the texel: opacity then adds up where a surface goes on.
    float part = brightness(mean.rgb) > 1.0 ? (is_front ? coverage.x / most.x : coverage.y / most.y) : 1.0;
    uint code = coverage_code(part);
    mean.rgb *= part / coverage_of_code(code);
    surface = vec4(min(UP * mean.rgb, HALF_MAX), with_coverage(mean.a, code, small));
}
