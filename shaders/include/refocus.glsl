// How focus follows its target: one step of the refocus law, and this frame's result.
//
// Twin: tests/oracles/refocus.py; vrcomfort/optics/refocus.py has the laws and their sources.
// LAW_DIOPTRE, LAW_SHARE, LAW_DURATION select a law at compile time; without them focus moves in metres.
uniform sampler2D before;  // `focus` one frame ago
uniform float step_size;   // how far focus may move now: metres; LAW_DIOPTRE dioptres, LAW_SHARE a
                           // share of the way, LAW_DURATION seconds since the frame before
layout(location = 0) out vec4 focus;  // x: focus distance, y: target, both metres along the head's
                                      // forward axis; z: rays used, bit k = ray k; w: 1
#ifdef LAW_DURATION
uniform sampler2D change_before;
uniform float duration_s;
uniform float refixation_dioptre;
layout(location = 1) out vec4 change;  // x: target for which the change began (m), y: seconds left
#endif

float towards(float current, float target, float most) {
    float way = target - current;
    return abs(way) <= most ? target : current + sign(way) * most;
}

float part_of_the_way(float current, float target, float share) {
    return share >= 1.0 ? target : current + (target - current) * share;
}

float refocused(float current, float target) {
#if defined(LAW_DURATION)
    vec2 state = texelFetch(change_before, ivec2(0), 0).xy;
    if (abs(1.0 / target - 1.0 / state.x) > refixation_dioptre) state = vec2(target, duration_s);
    float share = state.y > step_size ? step_size / state.y : 1.0;
    change = vec4(state.x, max(state.y - step_size, 0.0), 0.0, 1.0);
    return share >= 1.0 ? target : 1.0 / part_of_the_way(1.0 / current, 1.0 / target, share);
#elif defined(LAW_SHARE)
    return part_of_the_way(current, target, step_size);
#elif defined(LAW_DIOPTRE)
    return 1.0 / towards(1.0 / current, 1.0 / target, step_size);
#else
    return towards(current, target, step_size);
#endif
}

void refocus(float target, int rays_used) {
    float current = texelFetch(before, ivec2(0), 0).x;
    focus = vec4(refocused(current, target), target, float(rays_used), 1.0);
}
