#version 450 core
// See peak.vert. Output: the value itself.
flat in float value;

out float peak;

void main() {
    peak = value;
}
