"""Effects on the image of one eye, one module each.

`effect` is their interface. Each module holds its plan (whether it is there, and why), its passes,
and `EFFECT`, which `render.graph` finds.
"""
