"""Seeded inputs at the ends of every range: settings drawn from their schema, scenes, heads.

Settings are read from the pydantic models, so that a new setting, kernel or method is tried without
anybody listing it here.
"""

import typing
from itertools import count, islice
from types import NoneType, UnionType
from zlib import crc32

import numpy as np
from pydantic import BaseModel, ValidationError

from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, Gaze, Pose, View, axis_angle
from vrcomfort.protocol.conditions import CentredEffect, Condition
from vrcomfort.scene.animation import Animation, Channel
from vrcomfort.scene.data import (
    DirectionalLight,
    Environment,
    Image,
    Material,
    Node,
    PointLight,
    Primitive,
    Scene,
    SpotLight,
)

HALF_MAX = 65_504.0
SIZES = [(1, 1), (150, 24), (7, 5), (17, 33), (151, 25)]
NEAREST_M = (0.001, 0.01, 0.05, 1.0)
"""Near planes."""
FOCUS_M = (0.001, 0.017, 0.017 * 1.001, 1.0, 30_000.0, 1e9)
"""At, beside and beyond the focal length of an eye; at the sky and beyond it."""
ENDS = {
    "fixed_m": FOCUS_M,
    "focal_length_m": (0.001, 0.017, 0.2),
    "aperture_m": (0.0, 1e-6, 0.007, 1.0),
}
"""Settings of which not only the ends matter, or whose ends belong together."""
DISTANCES_M = (0.002, 0.1, 10.0, 30_000.0, np.inf)
SPEEDS_PX = (0.0, 1e-3, 0.4, 30.0, 2e3, 1e5)
MOST = {"views": 5, "samples": 256}
"""Settings that only cost time are tried up to here."""


def literals(annotation):
    """Return the choices of a Literal, or ()."""
    return typing.get_args(annotation) if typing.get_origin(annotation) is typing.Literal else ()


def models(annotation):
    """Return the settings models that an annotation such as ``DepthOfField | None`` names."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if typing.get_origin(annotation) in {typing.Union, UnionType}:
        return [each for part in typing.get_args(annotation) for each in models(part)]
    return []


def is_optional(annotation):
    return NoneType in typing.get_args(annotation)


def choices(model, path=()):
    """Yield (path, value) of every value of every Literal in a settings model, nested ones too."""
    for name, field in model.model_fields.items():
        for value in literals(field.annotation):
            yield (*path, name), value
        for nested in models(field.annotation):
            yield from choices(nested, (*path, name))


def drawn(model, rng, fixed=()):
    """Return settings at the ends of their ranges; `fixed` holds (path, value) pairs to keep."""
    for _ in range(100):
        try:
            return model(**_values(model, rng, dict(fixed)))
        except ValidationError:
            continue  # settings that exclude each other
    raise AssertionError(f"no valid {model.__name__} with {fixed}")


def named_rng(seed, name):
    """Return a generator of a name's own: what is added beside it does not move its numbers."""
    return np.random.default_rng([seed, crc32(name.encode())])


def _values(model, rng, fixed):
    values, seed = {}, int(rng.integers(2**32))
    for name, field in model.model_fields.items():
        rng = named_rng(seed, name)
        own = {path[1:]: value for path, value in fixed.items() if path[0] == name}
        if () in own:
            values[name] = own[()]
        elif nested := models(field.annotation):
            if own or not is_optional(field.annotation) or rng.random() < 0.6:
                values[name] = drawn(nested[0], rng, own.items())
        elif (value := _value(name, field, rng)) is not None:
            values[name] = value
    if values.get("method") == "scripted":
        late_s = float(named_rng(seed, "script").random())
        values["script"] = sorted({0.0: 0.05, late_s: 3e4}.items())
    if "of" in model.model_fields:
        values["of"] = typing.get_args(CentredEffect)
    if "foreground" in model.model_fields:
        values["foreground"] = [str(named_rng(seed, "foreground").choice(["*", "held", "[fl]*"]))]
    return values


def _value(name, field, rng):
    kind = field.annotation
    if kind == int | None:
        kind = int if rng.random() < 0.5 else None
    if options := literals(kind):
        return options[rng.integers(len(options))]
    if kind is bool:
        return bool(rng.random() < 0.5)
    if kind not in {int, float}:
        return None  # a default: names, labels, tables
    bounds = [getattr(limit, side, None) for limit in field.metadata for side in ("ge", "gt")]
    low = next((bound for bound in bounds if bound is not None), 0)
    tops = [getattr(limit, side, None) for limit in field.metadata for side in ("le", "lt")]
    high = next((top for top in tops if top is not None), 3e4 if name.endswith("_m") else 1e3)
    high = min(high, MOST.get(name, high))
    if name in ENDS:
        return float(rng.choice(ENDS[name]))
    if kind is int:
        return int(rng.integers(low, high + 1))
    least = max(low, 1e-3)
    ends = [low, high, least, least * (high / least) ** rng.random()]
    return float(rng.choice(ends, p=[0.1, 0.5, 0.1, 0.3]))


def conditions(rng):
    """Yield conditions for ever, first one for each value of each Literal (quality excepted)."""
    seed = int(rng.integers(2**32))
    every = [each for each in choices(Condition) if each[0] != ("quality",)]
    for number in count():
        first = every[number : number + 1]
        fixed = [*first, (("name",), "extreme"), (("quality",), None)]
        yield drawn(Condition, named_rng(seed, repr(first or number)), fixed)


def every_choice(rng):
    """Return conditions that together have every value of every Literal."""
    return list(islice(conditions(rng), sum(1 for _ in choices(Condition))))


def hdr(rng, shape):
    """Return radiance between two ends that differ from case to case: what comes out must, too."""
    low = rng.choice([0.0, 6e-8, 0.5])
    high = rng.choice([low, 1.0, 300.0, HALF_MAX])
    values = max(low, 1e-7) * (high / max(low, 1e-7)) ** rng.random(shape)
    return np.where(rng.random(shape) < 0.3, rng.choice([low, high], shape), values)


def distances(rng, shape):
    """Return distances from 2 mm to the sky, in patches with edges between them."""
    values = 10.0 ** rng.uniform(-2.7, 4.5, shape)
    return np.where(rng.random(shape) < 0.5, rng.choice(DISTANCES_M, shape), values)


def fov(rng):
    left, right, up, down = rng.uniform(0.2, 1.3, 4)
    return Fov(-left, right, up, -down)


def turn(rng, most_rad=np.pi):
    return axis_angle(rng.normal(size=3), rng.choice([0.0, 1e-4, 1.0]) * rng.uniform(0, most_rad))


def frames(rng, *, tracked, length=3):
    """Return frames whose head and avatar jump by up to kilometres and turn by up to 180°.

    `tracked`: each has a gaze, valid or not.
    """
    made = []
    for index in range(length):
        head = Pose(rng.normal(size=3) * rng.choice([0.0, 1e-3, 0.3]), turn(rng))
        avatar = Pose(rng.normal(size=3) * rng.choice([0.0, 0.0, 1.0, 5e3]), turn(rng))
        eyes = [Pose(np.array([x, 0, 0]), turn(rng, 0.4)) for x in (-0.0315, 0.0315)]
        gaze = Gaze(head @ Pose(np.zeros(3), turn(rng)), valid=bool(rng.random() < 0.8))
        made.append(
            Frame(
                index=index,
                predicted_display_time_ns=int(index * rng.choice([0, 1, 11_111_111, 10**10])),
                period_ns=11_111_111,
                head_pose=head,
                views=tuple(View(head @ eye, fov(rng)) for eye in eyes),
                avatar_pose=avatar,
                discontinuity=index == 0 or rng.random() < 0.1,
                snap_turn=bool(rng.random() < 0.2),
                gaze=gaze if tracked else None,
                hands=(head @ Pose(rng.normal(size=3), turn(rng)) if index else None, head),
            )
        )
    return made


IMAGE = Image(np.random.default_rng(0).integers(0, 256, (8, 8, 4), dtype=np.uint8))


def material(rng):
    """Return a surface: any alpha mode, with and without images, as bright as floats go or not."""
    glow = rng.choice([0.0, 1.0, 60_000.0, 1e6])
    maybe = lambda: 0 if rng.random() < 0.3 else None  # noqa: E731
    return Material(
        base_color=tuple(rng.choice([0.0, 0.5, 1.0], 4).tolist()),
        base_color_image=maybe(),
        normal_image=maybe(),
        normal_scale=float(rng.choice([0.0, 1.0, 100.0])),
        metallic=float(rng.choice([0.0, 1.0])),
        roughness=float(rng.choice([0.0, 0.3, 1.0])),
        metallic_roughness_image=maybe(),
        emissive=tuple((glow * rng.random(3)).tolist()),
        emissive_image=maybe(),
        alpha_mode=rng.choice(["OPAQUE", "MASK", "BLEND"]),
        alpha_cutoff=float(rng.choice([0.0, 0.5, 1.0])),
        double_sided=bool(rng.random() < 0.7),
    )


def primitive(rng, farthest_m, index, triangles=20):
    """Return triangles around the origin, a few mm to `farthest_m` away; some without any area,
    some with normals of no length, as files have them.
    """
    sizes = np.geomspace(0.003, farthest_m, triangles)[:, None, None]
    corners = rng.normal(0, 1, (triangles, 3, 3)) * sizes
    corners[::5, 2] = corners[::5, 1]
    normals = rng.normal(0, 1, (3 * triangles, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals.reshape(triangles, 9)[::3] = 0
    return Primitive(
        positions=corners.reshape(-1, 3).astype(np.float32),
        normals=normals.astype(np.float32),
        uvs=(rng.normal(0, 1, (3 * triangles, 2)) * rng.choice([0, 1, 1e5])).astype(np.float32),
        colors=rng.uniform(0, 1, (3 * triangles, 4)).astype("f4") if rng.random() < 0.5 else None,
        indices=np.arange(3 * triangles, dtype=np.uint32).reshape(-1, 3),
        material=index,
    )


def environment(rng):
    most = rng.choice([1.0, 60_000.0])
    bright = lambda: tuple((rng.choice([0.0, most]) * rng.random(3)).tolist())  # noqa: E731
    sun = rng.normal(size=3)
    lamps = tuple(
        PointLight(tuple(rng.normal(0, 5, 3).tolist()), bright(), float(10.0 ** rng.uniform(-3, 3)))
        for _ in range(rng.integers(0, 4))
    )
    # Of a generator of their own: the cases of other tests stay what they were.
    cones, far = _cones_and_far_lights(np.random.default_rng(int(1e9 * abs(sun[0]))), most)
    return Environment(
        sun_direction=sun / np.linalg.norm(sun),
        sun_irradiance=bright() if rng.random() < 0.6 else (0.0, 0.0, 0.0),
        sky_zenith=bright(),
        sky_horizon=bright(),
        ground=bright(),
        exposure=float(10.0 ** rng.uniform(-3, 3)),
        fog_density_per_m=float(rng.choice([0.0, 1e-3, 10.0])),
        fog_color=bright(),
        cloud_cover=float(rng.choice([0.0, 0.5, 1.0])),
        ambient_in_vertex_alpha=bool(rng.random() < 0.5),
        point_lights=lamps + cones,
        directional_lights=far,
    )


def _cones_and_far_lights(rng, most):
    """Return spot lights, some with next to no cone, and directional ones."""

    def towards():
        axis = rng.normal(size=3)
        return tuple((axis / np.linalg.norm(axis)).tolist())

    cones = tuple(
        SpotLight(tuple(rng.normal(0, 5, 3).tolist()), (most, 0.0, most),
                  10.0 ** rng.uniform(-3, 3), towards(), 0.0,
                  float(rng.choice([1e-6, 0.5, np.pi / 2])))
        for _ in range(rng.integers(0, 3))
    )  # fmt: skip
    far = tuple(DirectionalLight(towards(), (most, most, 0.0)) for _ in range(rng.integers(0, 3)))
    return cones, far


def scene(rng):
    """Return a scene of triangles on all sides: still, moving, flat (scale 0), held by the body."""
    primitives = tuple(primitive(rng, rng.choice([1.0, 30_000.0]), index) for index in range(2))
    nodes = (
        Node("still", mesh=(0,)),
        Node("moving", mesh=(1,), moving=True),
        Node("flat", mesh=(0,), scale=np.array([1.0, 0.0, 1.0])),
        Node("held", mesh=(1,), head_locked=True, translation=np.array([0.0, 0.0, -0.5])),
        Node("left", mesh=(0,), hand="left"),
        Node("right", mesh=(1,), hand="right", parent=1, moving=True),
    )
    jumps = np.cumsum(rng.normal(0, 1, (4, 3)) * [1.0, 1e2, 1e3], axis=0)
    path = Channel(1, "translation", np.array([0.0, 1e-3, 0.02, 1.0]), jumps, "LINEAR")
    return Scene(
        "extreme",
        nodes,
        primitives,
        (material(rng), material(rng)),
        images=(IMAGE,),
        animations=(Animation("jump", (path,), 1.0),),
        environment=environment(rng),
    )
