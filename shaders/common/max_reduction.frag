#version 450 core
// See max_reduction.vert. Output: the value itself.
flat in float value;

out float maximum;

void main() {
    maximum = value;
}
