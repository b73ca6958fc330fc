#version 450 core
// See frame_streaks.vert. Output: the values themselves, and the longest half velocity once more, for a
// target that keeps it over all frames.
flat in vec4 streaks;

layout(location = 0) out vec4 frame;
layout(location = 1) out float longest_of_all;

void main() {
    frame = streaks;
    longest_of_all = streaks.x;
}
