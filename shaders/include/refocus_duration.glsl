// Moves focus in dioptres so that each change takes the same time, however far it is.
//
// Input:  focus and target in metres; change_before: `change` one frame ago.
// Output: focus in metres; change: x: target for which the change began (m), y: seconds left.
// Twin:   tests/oracles/refocus.py. Laws: vrcomfort/optics/refocus.py.
uniform float step_size;  // seconds since the frame before
uniform sampler2D change_before;
uniform float duration_s;
uniform float refixation_dioptre;
layout(location = 1) out vec4 change;

float refocused(float current, float target) {
    vec2 state = texelFetch(change_before, ivec2(0), 0).xy;
    if (abs(1.0 / target - 1.0 / state.x) > refixation_dioptre) state = vec2(target, duration_s);
    float share = state.y > step_size ? step_size / state.y : 1.0;
    change = vec4(state.x, max(state.y - step_size, 0.0), 0.0, 1.0);
    float start = 1.0 / current;
    return share >= 1.0 ? target : 1.0 / (start + (1.0 / target - start) * share);
}
