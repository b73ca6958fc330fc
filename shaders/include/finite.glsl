// Light that can be averaged: what is not finite would spread over all that its disc covers.

const float HALF_MAX = 65504.0;

// A clamp alone of what is no number may give anything.
vec3 finite(vec3 light) {
    return clamp(mix(light, vec3(0.0), isnan(light)), 0.0, HALF_MAX);
}
