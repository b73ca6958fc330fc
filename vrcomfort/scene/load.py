"""Loads any glTF 2.0 file, and the TOML side-car beside it, as a `Scene`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.resources import data_folder
from vrcomfort.scene.data import (
    MOST_LAMPS,
    DirectionalLight,
    Environment,
    PointLight,
    Scene,
)
from vrcomfort.scene.defaults import with_defaults
from vrcomfort.scene.gltf.budget import SceneBudget
from vrcomfort.scene.gltf.file import STRUCTURE_ERRORS, read_gltf_file
from vrcomfort.scene.gltf.graph import read_graph, refuse_unknown
from vrcomfort.scene.gltf.mesh import read_materials, read_meshes
from vrcomfort.scene.gltf.parts import FARTHEST
from vrcomfort.scene.side_car import apply_side_car

SUFFIXES = (".glb", ".gltf")


def load_scene(name_or_path: str | Path, *, budget: SceneBudget | None = None) -> Scene:
    """Load a shipped scene by its name, or any .glb or .gltf file by its path.

    What the file has and this loader does not support is named in one string in
    `Scene.warnings`.

    Raises
    ------
    InputError
        If there is no such scene or file, or it (or its side-car) is broken, or costs more than
        the budget, or needs an extension or a file that it cannot have.
    """
    path = find_scene(name_or_path)
    try:
        scene, stand_ins = _read(path, budget)
    except InputError:
        raise
    except STRUCTURE_ERRORS as error:
        raise InputError(
            f"is not valid glTF 2.0 ({type(error).__name__}: {error}); "
            "check it with a glTF validator and export it again",
            file=path,
        ) from error
    scene = with_defaults(scene)
    side_car = path.with_suffix(".toml")
    if side_car.is_file():
        scene = apply_side_car(scene, stand_ins, side_car)
        _check_skins(scene, path)
    return _check_lamps(scene, path)


def find_scene(name_or_path: str | Path) -> Path:
    """Return the path of a scene file given by name or path."""
    path = Path(name_or_path)
    if path.suffix.lower() in SUFFIXES:
        if path.is_dir():
            raise InputError("is a folder; a scene is a .glb or .gltf file", file=path)
        if not path.is_file():
            raise InputError("there is no such scene file; check the path", file=path)
        return path
    folder = data_folder("scenes")
    shipped = sorted(file.stem for file in folder.glob("*.glb"))
    if str(name_or_path) in shipped:
        return folder / f"{name_or_path}.glb"
    raise InputError(
        f"there is no scene {str(name_or_path)!r}; use one of {', '.join(shipped)} "
        "or the path of a .glb or .gltf file"
    )


def _read(path: Path, budget: SceneBudget | None) -> tuple[Scene, dict[str, tuple[int, ...]]]:
    """Return the scene as the glTF file has it, and the meshes of nodes outside its graph."""
    file = read_gltf_file(path, budget)
    refuse_unknown(file)
    unsupported: set[str] = set()
    materials, images = read_materials(file, unsupported)
    primitives, meshes = read_meshes(file, unsupported)
    if not primitives:
        raise InputError(
            "has no triangles that can be drawn"
            + (f" (it needs {', '.join(sorted(unsupported))})" if unsupported else ""),
            file=path,
        )
    nodes, animations, skins, lights, stand_ins = read_graph(file, meshes, unsupported)
    scene = Scene(path.stem, nodes, primitives, materials, images, animations, skins=skins)
    _check_skins(scene, path)
    _check_places(scene, path)
    scene = replace(scene, environment=_lit(scene.environment, *lights))
    return replace(scene, warnings=_warning(path, unsupported)), stand_ins


def _lit(
    environment: Environment, lamps: tuple[PointLight, ...], far: tuple[DirectionalLight, ...]
) -> Environment:
    """Return the environment with a file's lights; the first directional one is the sun."""
    environment = replace(environment, point_lights=lamps, directional_lights=far[1:])
    if not far:
        return environment
    to_sun = -np.array(far[0].direction)
    return replace(environment, sun_direction=to_sun, sun_irradiance=far[0].irradiance)


def _check_lamps(scene: Scene, path: Path) -> Scene:
    """Refuse more lamps than can be drawn."""
    environment = scene.environment
    lamps = len(environment.point_lights) + len(environment.directional_lights)
    if lamps > MOST_LAMPS:
        raise InputError(
            f"has {lamps} lamps besides the sun, its own and those of its side-car; "
            f"{MOST_LAMPS} are the most: remove some",
            file=path,
        )
    return scene


def _check_skins(scene: Scene, path: Path) -> None:
    """Refuse a skin on a mesh, or a level of detail, that its joints cannot bend."""
    for node in scene.nodes:
        if node.skin is None:
            continue
        joints = [scene.nodes[joint] for joint in scene.skins[node.skin].joints]
        if any((each.head_locked, each.hand) != (node.head_locked, node.hand) for each in joints):
            message = f"node {node.name!r} and the joints of its skin go with different things"
            told = f"{message}; give both the same `head_locked` or `hand` in the side-car"
            raise InputError(told, file=path)
        count = len(joints)
        for index in (*node.mesh, *(item for level in node.lod for item in level.mesh)):
            bending = scene.primitives[index].bending
            if bending is None:
                wrong = "has no JOINTS_0 and WEIGHTS_0"
            elif bending.joints.max() >= count:
                wrong = f"has joint {bending.joints.max()} of {count}"
            else:
                continue
            message = f"node {node.name!r} has a skin, but a mesh of it {wrong}"
            raise InputError(f"{message}; export the file again", file=path)


def _check_places(scene: Scene, path: Path) -> None:
    """Refuse nodes beyond single precision: matrices multiply along a branch."""
    with np.errstate(over="ignore", invalid="ignore"):
        world = scene.world_from_joint(0.0)
        bends = np.abs(scene.all_skins.place_from_bind(world)).max(initial=0.0)
        placed = (np.abs(world) <= FARTHEST).all(axis=(1, 2))
    for node in np.array(scene.nodes)[~placed][:1]:
        message = (
            f"node {node.name!r} is scaled or moved by more than {FARTHEST:g} with those above"
        )
        raise InputError(f"{message} it; export the file again in metres", file=path)
    if not bends <= FARTHEST:
        message = f"a skin moves or scales its mesh by more than {FARTHEST:g}"
        raise InputError(f"{message}; export the file again in metres", file=path)


def _warning(path: Path, unsupported: set[str]) -> tuple[str, ...]:
    if not unsupported:
        return ()
    return (f"{path.name}: not supported and left out: {', '.join(sorted(unsupported))}",)
