// How focus follows its target: this frame's result.
//
// Needs one of refocus_*.glsl before it, which moves focus by a law: `refocused`. The shaders say
// refocus_law.glsl, and vrcomfort/optics/refocus says which one that is.
// Twin: tests/oracles/refocus.py.
uniform sampler2D before;  // `focus` one frame ago
layout(location = 0) out vec4 focus;  // x: focus distance, y: target, both metres from the head centre
                                      // along its forward axis, or with ALONG_RAY along a ray;
                                      // z: rays used, bit k = ray k; w: 1

void refocus(float target, int rays_used) {
    float current = texelFetch(before, ivec2(0), 0).x;
    focus = vec4(refocused(current, target), target, float(rays_used), 1.0);
}
