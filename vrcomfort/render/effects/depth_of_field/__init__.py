"""Depth of field: circles of confusion, kernels that spread them, and views through the lens.

To read in this order: `lens_radius` (settings in pixels), `coc_passes` (a signed radius for each
pixel), `layered_gather` (our kernel), `kernels` (those of papers and engines), `effect` (which puts
them together, and the mean of views through the lens).
"""
