"""NumPy twins of every formula in the shaders: focus, circle of confusion, shutter, tone.

Float64 and plain: a shader is right when it agrees with its twin.
"""
