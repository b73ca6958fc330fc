// Light that can be averaged: what is not finite would spread over all that its disc covers.

// Some renderers cut half floats off instead of rounding them: means must not fall short by a float's rounding.
const float UP = 1.0 + 1e-6;

// A clamp alone of what is no number may give anything.
vec3 finite(vec3 light) {
    return clamp(mix(light, vec3(0.0), isnan(light)), 0.0, HALF_MAX);
}
