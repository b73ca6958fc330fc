"""Surfaces of the mountain terrace: PNG pictures."""

from __future__ import annotations

import numpy as np

from .noise import cloud
from .texture import Ramp, blurred, coordinates, cutout_png, normal_png, ramp_png

WOOD: Ramp = [(48, 40, 34), (98, 86, 74), (140, 128, 112), (170, 158, 142)]


def needles_png(seed: int, size: int = 256) -> bytes:
    """Return a conifer branch on a transparent ground (stem along v, tip at v = 0)."""
    u, v = coordinates(size)
    x, along = (u - 0.5) * 2, 1 - v
    twig = 7
    alpha = np.abs(x) < 0.03
    for side in (1, -1):
        for index in range(twig):
            root = 0.03 + 0.93 * index / twig
            reach = 0.95 * (1 - root) ** 0.7 + 0.1
            t = side * x / reach
            line = along - root - 0.42 * t * reach
            comb = 0.5 + 0.5 * np.cos(2 * np.pi * 30 * (t + 0.4 * np.abs(line) * 8))
            alpha |= (
                (t > 0) & (t < 1) & (np.abs(line) < (0.052 + 0.03 * (1 - t)) * (0.55 + 0.45 * comb))
            )
    soft = blurred(alpha.astype(np.float64), 0.9)
    tone = 0.5 + 0.7 * (cloud(seed, size, exponent=1.0, low=4) - 0.5) + 0.2 * np.abs(x)
    color = np.stack([44 + 56 * tone, 66 + 64 * tone, 38 + 40 * tone], axis=-1)
    return cutout_png(color, np.clip(soft * 1.6, 0, 1))


def grass_png(seed: int, size: int = 256) -> bytes:
    """Return neutral blades that fan out from a root, on a transparent ground (root at v = 1).

    Their mean is that of the neutral turf, and vertex colours turn both into the land's cover.
    """
    rng = np.random.default_rng(seed)
    u, v = coordinates(size)
    alpha, tone = np.zeros((size, size)), np.zeros((size, size))
    for _ in range(52):
        root = rng.uniform(0.38, 0.62)
        lean = rng.uniform(-0.35, 0.35) + 0.9 * (root - 0.5)
        tall = rng.uniform(0.45, 0.98) * (1 - 0.5 * abs(lean))
        t = (1 - v) / tall
        blade = (np.abs(u - root - lean * t**1.6) < 0.016 * (1 - t) + 0.004) & (t < 1)
        alpha = np.where(blade, 1.0, alpha)
        tone = np.where(blade, rng.uniform(0, 1), tone)
    color = np.stack([146 + 62 * tone, 148 + 62 * tone, 136 + 62 * tone], axis=-1)
    empty = np.array([172.0, 174.0, 164.0])
    return cutout_png(np.where(alpha[..., None] > 0, color, empty), blurred(alpha, 0.5))


def path_png(seed: int, size: int = 512) -> bytes:
    """Return trodden gravel with ragged, transparent edges at u = 0 and 1."""
    u, _ = coordinates(size)
    pebbles = cloud(seed, size, exponent=0.35, low=20)
    broad = cloud(seed + 1, size, exponent=1.5, low=2)
    tone = 0.5 + 0.9 * (pebbles - 0.5) + 0.5 * (broad - 0.5)
    edge = np.minimum(u, 1 - u) + 0.55 * (broad - 0.5) + 0.18 * (pebbles - 0.5)
    color = np.stack([98 + 70 * tone, 86 + 64 * tone, 68 + 54 * tone], axis=-1)
    return cutout_png(color, np.clip((edge - 0.12) * 9 + 0.5, 0, 1))


def ground_maps(seed: int, size: int = 512) -> tuple[bytes, bytes]:
    """Return neutral turf: (albedo of mean NEUTRAL, normal map)."""
    fine = cloud(seed, size, exponent=0.55, low=12)
    broad = cloud(seed + 1, size, exponent=1.3, low=3)
    tone = 0.5 + 1.0 * (fine - 0.5) + 0.4 * (broad - 0.5)
    ramp: Ramp = [(110, 106, 96), (172, 174, 164), (222, 224, 210)]
    return ramp_png(tone, 0, [ramp]), normal_png(2.5 * fine + broad, strength=0.9)


def granite_maps(seed: int, size: int = 512) -> tuple[bytes, bytes]:
    """Return grey stone with lichen."""
    fine = cloud(seed, size, exponent=0.6, low=10)
    broad = cloud(seed + 1, size, exponent=1.5, low=2)
    lichen = broad + 0.35 * (cloud(seed + 2, size, exponent=1.0, low=8) - 0.5) > 0.68
    tone = 0.5 + 0.7 * (fine - 0.5) + 0.5 * (broad - 0.5)
    ramps: list[Ramp] = [
        [(66, 64, 62), (124, 120, 114), (178, 172, 164)],
        [(92, 96, 58), (146, 148, 96), (182, 182, 130)],
    ]
    return ramp_png(tone, lichen.astype(np.int64), ramps), normal_png(
        1.6 * fine + 2 * broad, strength=1.4
    )
