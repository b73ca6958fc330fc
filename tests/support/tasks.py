"""A room with a wall and a lamp, and a study in it whose participants have something to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from tests.support.protocols import ASKED_AFTER_EACH, NOBODY_LEAVES, protocol_text
from tests.support.session import run
from tests.support.study import AheadHeadset, LateFocus
from vrcomfort.protocol import Protocol, load_protocol, task_code_of, with_task_code
from vrcomfort.respondent import Respondent, SimulatedRespondent
from vrcomfort.scene.data import Material, Node, Primitive, Scene
from vrcomfort.session import RunOutcome

PROTOCOL = protocol_text(
    '[[tasks]]\nname = "shoot"\nkind = "aiming"\n',
    ASKED_AFTER_EACH,
    f"{NOBODY_LEAVES}task_effects = {{ blur = 2.0 }}\n",
    name="doing",
    exposure_s=20.0,
    keys='task = "shoot"\n',
)


def box(size_m: tuple[float, float, float]) -> Primitive:
    mesh = trimesh.creation.box(extents=size_m)
    points = mesh.triangles.reshape(-1, 3)
    return Primitive(
        points.astype(np.float32),
        np.repeat(mesh.face_normals, 3, axis=0).astype(np.float32),
        np.zeros((len(points), 2), dtype=np.float32),
        None,
        np.arange(len(points), dtype=np.uint32).reshape(-1, 3),
        0,
    )


def room() -> Scene:
    """Return a wall 5 m ahead of the world's origin, and a lamp 2 m ahead and 1 m to the right."""
    nodes = (
        Node("wall", translation=np.array([0.0, 0.0, -5.0]), mesh=(0,)),
        Node("lamp", translation=np.array([1.0, 0.0, -2.0]), mesh=(1,)),
    )
    parts = (box((20.0, 20.0, 0.1)), box((0.2, 0.2, 0.2)))
    return Scene("room", nodes, parts, (Material(),))


def doing_protocol(folder: Path, text: str = PROTOCOL) -> Protocol:
    folder.mkdir(exist_ok=True)
    (folder / "room.glb").touch()
    file = folder / "doing.toml"
    file.write_text(text, encoding="utf-8")
    return load_protocol(file)


def in_the_room(headset: type[AheadHeadset] = AheadHeadset) -> dict[str, object]:
    """Return what a session in the room needs of scene, headset and renderer."""
    return {
        "load_scene": lambda _: room(),
        "headset_for": lambda *_: headset(),
        "renderer": LateFocus(),
    }


def with_own_tasks(protocol: Protocol) -> Protocol:
    """Return a protocol with its own tasks ready, as after a consent."""
    return with_task_code(protocol, task_code_of(protocol))


def do(
    folder: Path,
    text: str = PROTOCOL,
    *,
    participant: str = "P01",
    respondent: Respondent | None = None,
    headset: type[AheadHeadset] = AheadHeadset,
    language: str | None = None,
    **more: object,
) -> RunOutcome:
    """Run a participant through the study in `folder / "S"`."""
    protocol = with_own_tasks(doing_protocol(folder, text).spoken(language))
    who = respondent or SimulatedRespondent(protocol.simulation, participant=participant, seed=0)
    parts = {**in_the_room(headset), **more}
    return run(protocol, participant, study=folder / "S", respondent=who, **parts)
