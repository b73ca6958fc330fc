"""OpenGL without a study: context, shaders, full-screen pass, timer, memory account."""
