// Moves focus by a share of the way to its target, in metres.
//
// Input:  focus and target in metres. Output: focus in metres.
// Twin:   tests/oracles/refocus.py. Laws: vrcomfort/optics/refocus.py.
uniform float step_size;  // share of the way; 1 and more: all of it

float refocused(float current, float target) {
    return step_size >= 1.0 ? target : current + (target - current) * step_size;
}
