"""Images, numbers and video on disk; the same run writes the same bytes.

Textures have their first row at the bottom, files at the top; everything here returns arrays with
the top row first.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import moderngl
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from vrcomfort.errors import InputError, pip_install
from vrcomfort.gpu import gl

if TYPE_CHECKING:
    import av

Rgb8 = NDArray[np.uint8]
Float32 = NDArray[np.float32]

_DTYPES = {"f1": np.uint8, "f2": np.float16, "f4": np.float32}


def read_texture(texture: moderngl.Texture) -> NDArray[np.generic]:
    """Return (height, width, components) of a single-sample texture, in its own type."""
    data = np.frombuffer(gl.read(texture), dtype=_DTYPES[texture.dtype])
    return data.reshape(texture.height, texture.width, -1)[::-1]


def read_rgb8(texture: moderngl.Texture) -> Rgb8:
    """Return (height, width, 3) of an RGBA8 texture."""
    return np.ascontiguousarray(read_texture(texture)[:, :, :3], dtype=np.uint8)


def read_linear(texture: moderngl.Texture) -> Float32:
    """Return (height, width, 3) linear light of an RGBA16F texture."""
    return np.ascontiguousarray(read_texture(texture)[:, :, :3], dtype=np.float32)


def read_depth(texture: moderngl.Texture) -> Float32:
    """Return (height, width) reverse-Z depth."""
    return np.ascontiguousarray(read_texture(texture)[:, :, 0], dtype=np.float32)


def distance_m(depth: Float32, near_m: float) -> Float32:
    """Return metres along the eye's axis of reverse-Z depth; the sky is at infinity."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.float32(near_m) / depth, dtype=np.float32)


def velocity_colours(velocity_px: NDArray[np.generic], full_px: float) -> Rgb8:
    """Return a picture of pixel velocities in the colours of optical flow: white is at rest.

    The hue is the direction (red to the right, then yellow, green and blue counterclockwise), and
    the colour is fullest from `full_px` on, as in Baker et al. 2011 (Middlebury).

    Parameters
    ----------
    velocity_px
        (height, width, 2) pixels per frame, +x right and +y up.
    """
    right, up = np.moveaxis(np.asarray(velocity_px, np.float64)[..., :2], -1, 0)
    share = np.minimum(np.hypot(right, up) / full_px, 1.0)
    hue = np.arctan2(up, right) / (2 * np.pi) % 1.0
    hsv = np.stack([hue, share, np.ones_like(share)], axis=-1)
    return np.asarray(Image.fromarray(np.round(hsv * 255).astype(np.uint8), "HSV").convert("RGB"))


def side_by_side(left: Rgb8, right: Rgb8) -> Rgb8:
    """Return both eyes in one (height, 2 · width, 3) image, the left eye on the left."""
    return np.concatenate([left, right], axis=1)


def write_png(path: Path, image: Rgb8) -> None:
    """Write an (height, width, 3) sRGB image."""
    # Fixed settings of the encoder: equal images are equal files.
    Image.fromarray(image, "RGB").save(path, optimize=False, compress_level=6)


def write_stereo(folder: Path, left: Rgb8, right: Rgb8) -> list[Path]:
    """Write ``left.png``, ``right.png`` and ``side_by_side.png``, and return their paths."""
    images = {"left": left, "right": right, "side_by_side": side_by_side(left, right)}
    paths = [folder / f"{name}.png" for name in images]
    for path, image in zip(paths, images.values(), strict=True):
        write_png(path, image)
    return paths


def write_numbers(path: Path, **arrays: NDArray[np.generic]) -> None:
    """Write named arrays to an .npz file."""
    with path.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


_TICK_S = Fraction(1, 90_000)
"""Of the times of frames in a video."""


def require_video() -> Any:
    """Return PyAV, which encodes videos.

    Raises
    ------
    InputError
        If it is not installed, or cannot be loaded.
    """
    try:
        import av  # noqa: PLC0415 - large, and only videos need it
    except ImportError as error:
        raise InputError(f"videos need PyAV ({error}); {pip_install('av')}") from error
    return av


class VideoWriter:
    """Encodes frames as H.264; one thread, so that the same frames give the same bytes.

    Parameters
    ----------
    path
        An .mp4 file; it is overwritten.
    frames_per_s
        Playback speed.
    quality
        Constant rate factor: 0 lossless, 18 visually so, 51 worst.

    Raises
    ------
    InputError
        If PyAV is missing.

    Notes
    -----
    Colour is subsampled by two: an odd last column or row is left out. Of images of up to
    96×72 pixels x264 makes other bytes in up to nine of a thousand videos; of 128×96 in none of
    3647.
    """

    def __init__(self, path: Path, *, frames_per_s: float, quality: int = 18) -> None:
        self._av = require_video()
        self._rate = Fraction(frames_per_s).limit_denominator(1000)
        self._quality = quality
        self._container = self._av.open(str(path), "w")
        self._stream: av.VideoStream | None = None
        self._written = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def write(self, image: Rgb8, time_s: float | None = None) -> None:
        """Append a (height, width, 3) frame; all frames have the size of the first.

        Parameters
        ----------
        time_s
            When it is seen, later than the frame before: times for all frames, or for none, which
            then follow each other at the playback speed.
        """
        even = np.ascontiguousarray(image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2])
        if self._stream is None:
            self._stream = self._open_stream(even.shape[1], even.shape[0])
        frame = self._av.VideoFrame.from_ndarray(even, format="rgb24")
        seen_s = self._written / self._rate if time_s is None else time_s
        frame.pts, frame.time_base = round(seen_s / _TICK_S), _TICK_S
        self._written += 1
        self._container.mux(self._stream.encode(frame))

    def close(self) -> None:
        """Finish the file."""
        if self._stream is not None:
            self._container.mux(self._stream.encode(None))
            self._stream = None
        self._container.close()

    def _open_stream(self, width: int, height: int) -> av.VideoStream:
        stream: av.VideoStream = self._container.add_stream("libx264", rate=self._rate)
        stream.width, stream.height = width, height
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": str(self._quality), "preset": "veryfast"}
        stream.codec_context.time_base = _TICK_S
        # The bytes of x264 depend on the number of threads.
        stream.codec_context.thread_count = 1
        stream.codec_context.thread_type = "NONE"
        return stream
