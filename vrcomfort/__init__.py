"""Comfort experiments for stereo head-mounted displays.

Importing this package needs neither a GPU nor an OpenXR runtime.
"""

__version__ = "0.1.0"
