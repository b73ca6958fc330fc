// Moves focus towards its target by so many dioptres, and no further than it.
//
// Input:  focus and target in metres. Output: focus in metres.
// Twin:   tests/oracles/refocus.py. Laws: vrcomfort/optics/refocus.py.
uniform float step_size;  // dioptres

float refocused(float current, float target) {
    float start = 1.0 / current;
    float way = 1.0 / target - start;
    return 1.0 / (abs(way) <= step_size ? 1.0 / target : start + sign(way) * step_size);
}
