"""What is computed before shaders run: focus, circle of confusion, patterns of taps, tone.

Float64, no OpenGL. Formulas that only shaders have are written once more in ``tests/oracles``: a
shader is right when it agrees with its twin.
"""
