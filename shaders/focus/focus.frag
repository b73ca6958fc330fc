#version 450 core
// Focus from nine rays: those that are no outliers and their mean, or (GAZE) their median.
//
// Input:  depth: 9x1 reverse-Z depths, near_m / distance, 0 = sky; texel 0 is the central ray.
// Output: include/refocus.glsl.
// Twin:   tests/oracles/focus.py. MEAN_DIOPTRES, GAZE and ALONG_RAY select variants at compile time.
// Source: Carnegie & Rhee 2015, p. 36, where the outlier rule (median absolute deviation) is ours;
//         GAZE: Mantiuk et al. 2011, section 4, where the median is ours.
#include "refocus_law.glsl"
#include "refocus.glsl"

uniform sampler2D depth;
uniform float near_m;
uniform float infinity_m;
uniform float outlier_mad;    // in scaled median absolute deviations
uniform float outlier_floor;  // share of the median, or dioptres with MEAN_DIOPTRES
#ifdef ALONG_RAY
uniform float ray_lengths[RAYS];  // metres along each ray per metre along the head's forward axis
#endif
#ifdef GAZE
uniform int estimate;  // 0: the mean, as without GAZE; 1: the median; 2: the target of before
#endif

const float MAD_TO_SIGMA = 1.4826;

// The value that four of nine are below; equal values rank in order of their index.
float median(float values[RAYS]) {
    for (int i = 0; i < RAYS; ++i) {
        int below = 0;
        for (int j = 0; j < RAYS; ++j)
            below += int(values[j] < values[i] || (values[j] == values[i] && j < i));
        if (below == RAYS / 2) return values[i];
    }
    return values[0];
}

float metres_of(int ray) {
    float z = texelFetch(depth, ivec2(ray, 0), 0).x;
    float near = near_m;
#ifdef ALONG_RAY
    near *= ray_lengths[ray];
#endif
    return z * infinity_m > near ? near / z : infinity_m;
}

#ifdef GAZE
void refocus_by_gaze() {
    if (estimate == 2) {
        refocus(texelFetch(before, ivec2(0), 0).y, 0);
        return;
    }
    float metres[RAYS];
    for (int k = 0; k < RAYS; ++k) metres[k] = metres_of(k);
    float middle = median(metres);
    int used = 0;
    for (int k = 0; k < RAYS; ++k) used |= int(metres[k] == middle) << k;
    refocus(middle, used);
}
#endif

void main() {
#ifdef GAZE
    if (estimate != 0) {
        refocus_by_gaze();
        return;
    }
#endif
    float values[RAYS];
    for (int k = 0; k < RAYS; ++k) {
#ifdef MEAN_DIOPTRES
        values[k] = 1.0 / metres_of(k);
#else
        values[k] = metres_of(k);
#endif
    }
    float middle = median(values);
    float deviations[RAYS];
    for (int k = 0; k < RAYS; ++k) deviations[k] = abs(values[k] - middle);
#ifdef MEAN_DIOPTRES
    float least = outlier_floor;
#else
    float least = outlier_floor * middle;
#endif
    float limit = max(outlier_mad * MAD_TO_SIGMA * median(deviations), least);

    // Deviations are averaged, not values: nine equal rays then give exactly their distance.
    float sum = 0.0, count = 0.0;
    int used = 0;
    for (int k = 0; k < RAYS; ++k)
        if (deviations[k] <= limit) {
            sum += values[k] - middle;
            count += 1.0;
            used |= 1 << k;
        }
    float target = middle + sum / count;
#ifdef MEAN_DIOPTRES
    target = 1.0 / target;
#endif
    refocus(target, used);
}
