// Moves focus towards its target by so many metres, and no further than it.
//
// Input:  focus and target in metres. Output: focus in metres.
// Twin:   tests/oracles/refocus.py. Laws: vrcomfort/optics/refocus.py.
uniform float step_size;  // metres

float refocused(float current, float target) {
    float way = target - current;
    return abs(way) <= step_size ? target : current + sign(way) * step_size;
}
