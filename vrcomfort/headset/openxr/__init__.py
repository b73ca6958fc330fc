"""A headset behind an OpenXR runtime; the only package that imports `xr`."""

from vrcomfort.headset.openxr.headset import OpenXrHeadset
from vrcomfort.headset.openxr.settings import OpenXrSettings

__all__ = ["OpenXrHeadset", "OpenXrSettings"]
