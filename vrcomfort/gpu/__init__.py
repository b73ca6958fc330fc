"""OpenGL without a study: context, textures, shaders, passes, timers, traffic, memory account."""
