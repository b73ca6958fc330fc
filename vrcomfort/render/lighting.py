"""The uniform block of light (``shaders/include/light.glsl``), filled from an environment."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array
from vrcomfort.gpu import shaders
from vrcomfort.scene.data import MOST_LAMPS, Environment, PointLight, Rgb, Scene, SpotLight


def has_sun(environment: Environment) -> bool:
    """Return whether the sun shines: only then is there a shadow map."""
    return any(component > 0 for component in environment.sun_irradiance)


def features(environment: Environment) -> shaders.Defines:
    """Return the defines of a scene's light; absent kinds of light are not compiled in."""
    present = {
        "SUN": has_sun(environment),
        "LAMPS": bool(environment.point_lights or environment.directional_lights),
        "CONES": any(isinstance(lamp, SpotLight) for lamp in environment.point_lights),
        "FAR_LAMPS": bool(environment.directional_lights),
        "FOG": environment.fog_density_per_m > 0,
        "CLOUDS": environment.cloud_cover > 0,
    }
    return {name: 1 for name, needed in present.items() if needed}


class Light:
    """Fills the uniform blocks of light. Positions follow the eyes: `look_from`.

    Parameters
    ----------
    blocks
        (views,) of the layout that ``light.glsl`` declares; they are written into.

    Raises
    ------
    InputError
        If the scene has more lamps than the shader has room for.
    """

    def __init__(self, scene: Scene, blocks: NDArray[np.void]) -> None:
        lamps = scene.environment.point_lights
        count = len(lamps) + len(scene.environment.directional_lights)
        if count > MOST_LAMPS:
            raise InputError(
                f"scene {scene.name!r} has {count} lamps besides the sun; {MOST_LAMPS} are the most"
            )
        _write_environment(blocks, scene.environment)
        self._world_m = np.array([lamp.position for lamp in lamps]).reshape(-1, 3)
        self._lamps = blocks["lamp_position"][:, : len(lamps), :3]
        self._shadow_from_relative = blocks["shadow_from_relative"]
        self._bias = blocks["shadow_bias"]

    def look_from(self, eyes_m: Array, shadow: ShadowUniforms | None) -> None:
        """Write positions relative to the eyes of the first blocks.

        Parameters
        ----------
        eyes_m
            (eyes, 3) world positions.
        shadow
            None without a sun.
        """
        lamps, moved = self._lamps[: len(eyes_m)], eyes_m[:, None]
        np.subtract(self._world_m, moved, out=lamps, casting="same_kind")
        if shadow is not None:
            rows = shadow.from_world.T  # GLSL stores columns
            found = self._shadow_from_relative[: len(eyes_m)]
            found[:, :3], found[:, 3] = rows[:3], rows[3] + eyes_m @ rows[:3]
            self._bias[...] = shadow.bias


class ShadowUniforms(NamedTuple):
    """Shadow map as the block of light reads it.

    `from_world` is (4, 4) to its texture coordinates and depth; `bias` (4,) is ``shadow_bias`` of
    light.glsl.
    """

    from_world: Array
    bias: Array


def relative_to(target_from_world: Array, origin_m: Array) -> Array:
    """Return target-from-relative, where relative = world axes with `origin_m` as origin."""
    matrix = target_from_world.copy()
    matrix[:, 3] += target_from_world[:, :3] @ origin_m
    return matrix


class LampReach:
    """Which lamps reach which boxes."""

    def __init__(self, environment: Environment) -> None:
        lamps, far = environment.point_lights, environment.directional_lights
        positions = [lamp.position for lamp in lamps] + [(0.0, 0.0, 0.0)] * len(far)
        ranges_m = [lamp.range_m for lamp in lamps] + [np.inf] * len(far)
        self._positions = np.array(positions).reshape(-1, 3).T[:, :, None]
        self._squares = np.array(ranges_m)[:, None] ** 2
        self._powers = 2.0 ** np.arange(len(ranges_m))

    def bits(self, centers: Array, halves: Array) -> Array:
        """Return (n,) bit sets of the lamps in range of each of n world-space boxes.

        A float holds 16 bits exactly, and travels as an ordinary instance attribute.
        """
        if not len(self._powers):
            return np.zeros(len(centers))
        beyond = np.abs(self._positions - centers.T[:, None]) - halves.T[:, None]
        np.maximum(beyond, 0.0, out=beyond)
        beyond *= beyond
        return np.asarray(self._powers @ (beyond[0] + beyond[1] + beyond[2] < self._squares))


def _write_environment(blocks: NDArray[np.void], environment: Environment) -> None:
    blocks["sun_direction"][..., :3] = environment.sun_direction
    for name in ("sun_irradiance", "sky_zenith", "sky_horizon", "ground"):
        blocks[name][..., :3] = getattr(environment, name)
    blocks["fog"] = (*environment.fog_color, environment.fog_density_per_m)
    blocks["clouds"][..., 0] = environment.cloud_cover
    for index, lamp in enumerate(environment.point_lights):
        blocks["lamp_position"][..., index, 3] = lamp.range_m
        direction, scale, offset = _cone(lamp)
        blocks["lamp_intensity"][..., index, :] = (*lamp.intensity, offset)
        blocks["lamp_direction"][..., index, :] = (*direction, scale)
    for index, far in enumerate(environment.directional_lights, len(environment.point_lights)):
        blocks["lamp_position"][..., index, :3] = -np.array(far.direction)
        blocks["lamp_intensity"][..., index, :] = (*far.irradiance, 1.0)


def _cone(lamp: PointLight) -> tuple[Rgb, float, float]:
    """Return direction, scale and offset of ``cone`` in light.glsl."""
    if not isinstance(lamp, SpotLight):
        return (0.0, 0.0, 0.0), 0.0, 1.0
    inner, outer = np.cos(lamp.inner_cone_rad), np.cos(lamp.outer_cone_rad)
    scale = 1.0 / max(1e-3, inner - outer)
    return lamp.direction, scale, -outer * scale
