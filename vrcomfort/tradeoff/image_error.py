"""How far an image is from its reference, on linear HDR radiance before tone mapping."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter

from vrcomfort.errors import InputError, pip_install
from vrcomfort.geometry import Array, Fov, focal_length_px

Image = NDArray[np.floating]

EXPOSURES = (-1.0, 1.0, 3)
"""First and last exposure of HDR-FLIP in stops around the scene's own, and how many."""

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Of linear Rec. 709."""

SSIM_REACH_PX = 5

MARGIN = 0.125
"""Part of the image's width left out at its borders: light that blurs in from outside the image is
in no post-process's input."""

HIGHLIGHT = 8.0
"""Radiance (display white is 1) above which a pixel is left out: the sun's disc is smaller than a
pixel, and a few pixels of it would be the whole error."""

UNSURE = 0.25
"""A pixel is left out where the halves of the reference differ by more."""


class Accuracy(NamedTuple):
    """Errors of one image against a reference and how sure the reference is of itself."""

    psnr_db: float
    flip: float
    rms: float
    reference_rms: float
    """Estimated root mean square error of the reference, from its two halves."""
    reference_flip: float
    """FLIP between the two halves, which is about twice the reference's own."""
    margin_px: int
    """How wide a margin was left out."""
    left_out_px: int
    """How many pixels inside the margin were left out, as too bright or unsure."""
    compared_px: int
    """How many pixels were compared."""

    @property
    def counts(self) -> bool:
        """Return whether the reference's own error is at most a tenth of the measured one."""
        return self.reference_rms <= 0.1 * self.rms


def rms(test: ArrayLike, reference: ArrayLike, /) -> float:
    """Return the root mean square difference of two (h, w, 3) images."""
    difference = _image(test) - _image(reference)
    return math.sqrt(float(np.mean(difference**2)))


def psnr_db(test: ArrayLike, reference: ArrayLike, /, *, peak: float = 1.0) -> float:
    """Return the peak signal-to-noise ratio in decibels; infinite where both are the same.

    Parameters
    ----------
    peak
        Fixed radiance that counts as full signal: display white, not the image's maximum, so that
        images with and without highlights compare.
    """
    error = rms(test, reference)
    return math.inf if error == 0 else 20 * math.log10(peak / error)


def pixels_per_degree(fov: Fov, size_px: tuple[int, int]) -> float:
    """Return the pixels per degree of visual angle in the middle of an eye's image."""
    return focal_length_px(fov, size_px)[0] * math.radians(1)


def require_flip() -> Any:
    """Return the package that computes FLIP; it has no wheel for some machines.

    Raises
    ------
    InputError
        If it is not installed, or cannot be loaded.
    """
    try:
        import flip_evaluator  # noqa: PLC0415 - see above
    except ImportError as error:
        remedy = f"{pip_install('flip-evaluator')} (a C++ compiler where it has no wheel)"
        raise InputError(f"FLIP needs flip-evaluator ({error}); {remedy}") from error
    return flip_evaluator


def hdr_flip(test: ArrayLike, reference: ArrayLike, /, *, pixels_per_degree: float) -> float:
    """Return the mean HDR-FLIP of two (h, w, 3) linear images: see :func:`hdr_flip_map`."""
    return float(hdr_flip_map(test, reference, pixels_per_degree=pixels_per_degree).mean())


def hdr_flip_map(
    test: ArrayLike, reference: ArrayLike, /, *, pixels_per_degree: float
) -> NDArray[np.float32]:
    """Return the (h, w) HDR-FLIP of two (h, w, 3) linear images: 0 alike, 1 most different.

    Images are scaled so that 1 is display white; exposures are fixed at :data:`EXPOSURES`, or else
    every image would be judged on a scale of its own.

    Notes
    -----
    Andersson et al., "Visualizing errors in rendered high dynamic range images", 2021.
    """
    first, last, count = EXPOSURES
    parameters = {
        "ppd": pixels_per_degree,
        "startExposure": first,
        "stopExposure": last,
        "numExposures": count,
        "tonemapper": "ACES",
    }
    found, _, _ = require_flip().evaluate(
        np.ascontiguousarray(_image(reference), dtype=np.float32),
        np.ascontiguousarray(_image(test), dtype=np.float32),
        "HDR",
        inputsRGB=False,
        applyMagma=False,
        parameters=parameters,
    )
    errors: NDArray[np.float32] = found[..., 0]
    return errors


def ssim(test: ArrayLike, reference: ArrayLike, /, *, peak: float = 1.0) -> float:
    """Return the mean structural similarity of the luminance of two (h, w, 3) images.

    Rims are left out where the window (11 × 11, Gaussian of 1.5 px) is not whole, unless an image
    is smaller than that.

    Notes
    -----
    Wang et al., "Image quality assessment: from error visibility to structural similarity", 2004;
    K1 = 0.01, K2 = 0.03; variances of the population, as there.
    """
    a, b = (_image(pixels) @ LUMINANCE for pixels in (test, reference))
    first, second = (0.01 * peak) ** 2, (0.03 * peak) ** 2
    mean_a, mean_b = _windowed(a), _windowed(b)
    variance_a, variance_b = _windowed(a * a) - mean_a**2, _windowed(b * b) - mean_b**2
    covariance = _windowed(a * b) - mean_a * mean_b
    likeness = (2 * mean_a * mean_b + first) * (2 * covariance + second)
    likeness /= (mean_a**2 + mean_b**2 + first) * (variance_a + variance_b + second)
    rim = SSIM_REACH_PX if min(a.shape) > 2 * SSIM_REACH_PX else 0
    return float(np.mean(likeness[rim : a.shape[0] - rim, rim : a.shape[1] - rim]))


def _windowed(image: Array) -> Array:
    mean: Array = gaussian_filter(image, sigma=1.5, radius=SSIM_REACH_PX)
    return mean


def accuracy(
    test: ArrayLike,
    halves: tuple[ArrayLike, ArrayLike],
    /,
    *,
    pixels_per_degree: float,
    exposure: float = 1.0,
) -> Accuracy:
    """Compare an image with a reference given as two independent halves, where they are sure.

    Two halves with independent errors of variance v differ by 2v, and their mean, the reference,
    has v/2: its error is half the difference of the halves.

    Raises
    ------
    InputError
        If the image is all margin.
    """
    halves = _image(halves[0]), _image(halves[1])
    counted = sure(halves, exposure=exposure)
    image, first, second = (judged(_image(each), counted, exposure) for each in (test, *halves))
    reference = (first + second) / 2
    margin = margin_px((counted.shape[1], counted.shape[0]))
    compared = int(counted[margin:-margin, margin:-margin].sum())
    return Accuracy(
        psnr_db=psnr_db(image, reference),
        flip=hdr_flip(image, reference, pixels_per_degree=pixels_per_degree),
        rms=rms(image, reference),
        reference_rms=rms(first, second) / 2,
        reference_flip=hdr_flip(first, second, pixels_per_degree=pixels_per_degree),
        margin_px=margin,
        left_out_px=image.shape[0] * image.shape[1] - compared,
        compared_px=compared,
    )


def sure(halves: tuple[Array, Array], /, *, exposure: float) -> NDArray[np.bool_]:
    """Return (h, w, 1): whether the two halves of a reference are sure of a pixel."""
    first, second = (half * exposure for half in halves)
    wild = (np.maximum(first, second) > HIGHLIGHT) | (np.abs(first - second) > UNSURE)
    found: NDArray[np.bool_] = ~np.any(wild, axis=-1, keepdims=True)
    return found


def judged(
    pixels: Image,
    counted: NDArray[np.bool_],
    exposure: float,
    area: tuple[slice, slice] | None = None,
) -> Array:
    """Return the compared pixels: exposed, without the margin, 0 where a pixel does not count.

    Parameters
    ----------
    area
        Rows and columns to compare, where the image is only a part of one that has a margin.
    """
    exposed: Array = np.where(counted, pixels.astype(np.float64) * exposure, 0.0)
    return exposed[area or inside_margin((pixels.shape[1], pixels.shape[0]))]


def inside_margin(size_px: tuple[int, int]) -> tuple[slice, slice]:
    """Return the rows and columns of a (width, height) image that are not in its margin."""
    margin = margin_px(size_px)
    return slice(margin, size_px[1] - margin), slice(margin, size_px[0] - margin)


def margin_px(size_px: tuple[int, int]) -> int:
    """Return the width of the margin that is left out of a (width, height) image.

    Raises
    ------
    InputError
        If nothing is left.
    """
    width, height = size_px
    margin = math.ceil(MARGIN * width)
    if 2 * margin >= min(width, height):
        raise InputError(
            f"at {width}x{height} pixels nothing can be compared: all of it lies in the margin "
            f"(an eighth of the width: {margin} px) that is left out; choose a larger --size"
        )
    return margin


def _image(pixels: ArrayLike) -> Array:
    image = np.asarray(pixels, dtype=np.float64)
    if image.ndim != 3 or image.shape[2] != 3:
        raise InputError(f"an image must be (height, width, 3), not {image.shape}")
    return image
