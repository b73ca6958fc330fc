"""The uniform block of light (``shaders/include/light.glsl``), filled from an environment."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.geometry import Array
from vrcomfort.gpu import gl, shaders
from vrcomfort.scene.data import Environment, Scene

LIGHT_BINDING = 1


def has_sun(environment: Environment) -> bool:
    """Return whether the sun shines: only then is there a shadow map."""
    return any(component > 0 for component in environment.sun_irradiance)


def features(environment: Environment) -> shaders.Defines:
    """Return the defines of what a scene's light needs; absent things are not compiled in."""
    present = {
        "SUN": has_sun(environment),
        "LAMPS": bool(environment.point_lights),
        "FOG": environment.fog_density_per_m > 0,
        "CLOUDS": environment.cloud_cover > 0,
    }
    return {name: 1 for name, needed in present.items() if needed}


class Light:
    """Light on the GPU. Positions follow the eye: call `update` for each view.

    Raises
    ------
    InputError
        If the scene has more lamps than the shader has room for.
    """

    def __init__(self, ctx: moderngl.Context, scene: Scene) -> None:
        lamps = scene.environment.point_lights
        self._block = np.zeros((), shaders.block_dtype("light.glsl", "Light"))
        most = len(self._block["lamp_position"])
        if len(lamps) > most:
            raise InputError(
                f"scene {scene.name!r} has {len(lamps)} point lights; at most {most} are drawn"
            )
        _write_environment(self._block, scene.environment)
        self._positions = np.array([lamp.position for lamp in lamps]).reshape(-1, 3)
        self._buffer = gl.dynamic_buffer(ctx, self._block.nbytes)

    def update(self, eye_m: Array, shadow_from_world: Array | None, bias: Array | None) -> None:
        """Write and bind the block for an eye.

        Parameters
        ----------
        eye_m
            (3,) world position.
        shadow_from_world
            (4, 4) to texture coordinates and depth of the shadow map, or None without a sun.
        bias
            (4,) see ``shadow_bias`` in light.glsl.
        """
        count = len(self._positions)
        self._block["lamp_position"][:count, :3] = self._positions - eye_m
        if shadow_from_world is not None and bias is not None:
            self._block["shadow_from_relative"] = relative_to(shadow_from_world, eye_m).T
            self._block["shadow_bias"] = bias
        self._buffer.write(self._block.tobytes())
        self._buffer.bind_to_uniform_block(LIGHT_BINDING)


def relative_to(target_from_world: Array, origin_m: Array) -> Array:
    """Return target-from-relative, where relative = world axes with `origin_m` as origin."""
    matrix = target_from_world.copy()
    matrix[:, 3] += target_from_world[:, :3] @ origin_m
    return matrix


def lamp_bits(scene: Scene, centers: Array, halves: Array) -> NDArray[np.float32]:
    """Return (n,) bit sets of the lamps whose range touches each of n world-space boxes.

    A float holds 16 bits exactly, and travels as an ordinary instance attribute.
    """
    lamps = scene.environment.point_lights
    positions = np.array([lamp.position for lamp in lamps]).reshape(-1, 1, 3)
    ranges = np.array([lamp.range_m for lamp in lamps])[:, None]
    beyond = np.maximum(np.abs(positions - centers) - halves, 0.0)
    near = np.einsum("lni,lni->ln", beyond, beyond) < ranges**2
    return np.asarray(2.0 ** np.arange(len(lamps)) @ near, dtype=np.float32)


def _write_environment(block: NDArray[np.void], environment: Environment) -> None:
    block["sun_direction"][:3] = environment.sun_direction
    for name in ("sun_irradiance", "sky_zenith", "sky_horizon", "ground"):
        block[name][:3] = getattr(environment, name)
    block["fog"] = (*environment.fog_color, environment.fog_density_per_m)
    block["clouds"][0] = environment.cloud_cover
    for index, lamp in enumerate(environment.point_lights):
        block["lamp_position"][index, 3] = lamp.range_m
        block["lamp_intensity"][index, :3] = lamp.intensity
