"""A headset behind an OpenXR runtime; the only package that imports `xr`."""

import os

os.environ.setdefault("XR_LOADER_DEBUG", "none")  # what the loader prints, we say in a sentence

from vrcomfort.headset.openxr.headset import OpenXrHeadset
from vrcomfort.headset.openxr.settings import OpenXrSettings

__all__ = ["OpenXrHeadset", "OpenXrSettings"]
