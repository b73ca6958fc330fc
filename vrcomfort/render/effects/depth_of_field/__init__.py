"""Depth of field: circles of confusion, kernels, views through the lens."""
