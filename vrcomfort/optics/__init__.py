"""Float64 models behind the shaders: focus, circle of confusion, blur kernels, motion, tone.

No OpenGL. Formulas that only shaders have are written once more in ``tests/oracles``: a shader is
right when it agrees with its twin.
"""
