// How streaks are read: bilinear, or with CUBIC sharper across the streak.
//
// Source of the cubic: Catmull and Rom 1974.

uniform eye_image source;  // linear HDR, filtered

// Pixels along each axis for which there is one texel.
#ifndef PX_PER_TEXEL
#define PX_PER_TEXEL vec2(1.0)
#endif

vec2 texel = 1.0 / (PX_PER_TEXEL * vec2(size_of(source)));

vec3 read(vec2 at_px) {
    return filtered_at(source, at_px * texel).rgb;
}

#ifdef CUBIC
// Catmull-Rom across the streak, on the axis along which it is shorter: a bilinear read blurs there
// as well. The two middle rows are read at once, where the filter weighs them as the curve does.
// The mean is no brighter or darker than all that was read.
vec3 least = vec3(HALF_MAX), greatest = vec3(0.0);

vec3 read_across(vec2 at_px, vec2 across) {
    float t = dot(fract(at_px - 0.5), across);
    vec2 row = at_px - t * across;
    float before = t * (t * (1.0 - 0.5 * t) - 0.5), after = t * t * (0.5 * t - 0.5);
    float first = 1.0 + t * t * (1.5 * t - 2.5), second = t * (0.5 + t * (2.0 - 1.5 * t));
    float middle = first + second;
    vec3 a = read(row - across), b = read(row + second / middle * across);
    vec3 c = read(row + 2.0 * across);
    least = min(least, min(min(a, b), c));
    greatest = max(greatest, max(max(a, b), c));
    return before * a + middle * b + after * c;
}
#else
vec3 read_across(vec2 at_px, vec2 across) {
    return read(at_px);
}
#endif

#ifdef HALVED
// Means of two pixels, and reads between them, add 1/4 + 1/2 px^2 to the variance u^2 / 3 of a streak:
// it is made as much shorter.
const float WIDENED_PX2 = 3.0 * (0.25 + 0.5);

vec2 shortened(vec2 half_velocity) {
    float squared = max(dot(half_velocity, half_velocity), WIDENED_PX2);
    return half_velocity * sqrt(1.0 - WIDENED_PX2 / squared);
}
#endif

// The axis across a streak: that of the image along which it is shorter.
vec2 axis_across(vec2 half_velocity) {
    vec2 extent = abs(half_velocity);
    return extent.x < extent.y ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
}

// A mean of reads, in the range of what was read; `own` is the pixel's.
vec3 mean_of_reads(vec3 mean, vec3 own) {
#ifdef CUBIC
    mean = clamp(mean, min(least, own), max(greatest, own));
#endif
    return min(mean, HALF_MAX);
}
