#version 450 core
// Focus: which of nine rays are no outliers, their mean, and one step of the refocus law.
//
// Input:  depth: 9x1 reverse-Z depths, near_m / distance, 0 = sky; texel 0 is the central ray.
//         before: this shader's result one frame ago.
// Output: 1x1. x: focus distance, y: the mean before the law, both metres along the head's
//         forward axis; z: rays used, bit k = ray k; w: 1.
// Twin:   vrcomfort/optics/focus.py. MEAN_DIOPTRES, LAW_DIOPTRE select variants at compile time.
// Source: Carnegie & Rhee 2015, p. 36; the outlier rule (median absolute deviation) is ours.
uniform sampler2D depth;
uniform sampler2D before;
uniform float near_m;
uniform float infinity_m;
uniform float outlier_mad;    // in scaled median absolute deviations
uniform float outlier_floor;  // share of the median, or dioptres with MEAN_DIOPTRES
uniform float step_size;      // metres, or dioptres with LAW_DIOPTRE, that focus may move now
out vec4 focus;

const int RAYS = 9;
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

float towards(float current, float target, float most) {
    float way = target - current;
    return abs(way) <= most ? target : current + sign(way) * most;
}

void main() {
    float values[RAYS];
    for (int k = 0; k < RAYS; ++k) {
        float z = texelFetch(depth, ivec2(k, 0), 0).x;
        float metres = z * infinity_m > near_m ? near_m / z : infinity_m;
#ifdef MEAN_DIOPTRES
        values[k] = 1.0 / metres;
#else
        values[k] = metres;
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
    float raw = middle + sum / count;
#ifdef MEAN_DIOPTRES
    raw = 1.0 / raw;
#endif

    float current = texelFetch(before, ivec2(0), 0).x;
#ifdef LAW_DIOPTRE
    float now = 1.0 / towards(1.0 / current, 1.0 / raw, step_size);
#else
    float now = towards(current, raw, step_size);
#endif
    focus = vec4(now, raw, float(used), 1.0);
}
