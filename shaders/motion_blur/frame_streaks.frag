#version 450 core
// See frame_streaks.vert. Output: the values themselves, and the longest half velocity once more, for a
// target that keeps it over all frames.
flat in vec3 streaks;

layout(location = 0) out vec4 frame;
layout(location = 1) out float longest_of_all;

void main() {
    frame = vec4(streaks, 0.0);
    longest_of_all = streaks.x;
}
