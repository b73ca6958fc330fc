"""Renderers without a window, and the machine's facts for a manifest."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vrcomfort.files import sha256_of
from vrcomfort.frame import STIMULUS_VERSION
from vrcomfort.geometry import HiddenAreas
from vrcomfort.protocol import Protocol
from vrcomfort.protocol.viewing import Photodiode
from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from vrcomfort.records import Machine
    from vrcomfort.render.pipeline import StereoRenderer


def make_renderer(
    size_px: tuple[int, int],
    *,
    hash_every: int = 0,
    photodiode: Photodiode | None = None,
    finds_hits: bool = False,
    hidden: HiddenAreas = (None, None),
) -> StereoRenderer:
    """Return a renderer on a context of its own, without a window."""
    from vrcomfort.gpu.gl import create_context
    from vrcomfort.render.pipeline import StereoRenderer

    ctx = create_context()
    return StereoRenderer(
        ctx,
        size_px,
        hash_every=hash_every,
        photodiode=photodiode,
        finds_hits=finds_hits,
        hidden=hidden,
    )


def describe_machine(renderer: StereoRenderer, protocol: Protocol) -> Machine:
    """Return the machine's facts for the manifest: driver, shaders, passes of each condition."""
    from vrcomfort.gpu.gl import describe
    from vrcomfort.headset.timing import TimingTrust
    from vrcomfort.records import Machine
    from vrcomfort.render.graph import plan_passes
    from vrcomfort.scene.load import load_scene
    from vrcomfort.text_layout import layout_facts

    facts = describe(renderer.ctx)
    passes = {
        f"{condition.name} in {name}": [
            step.name for step in plan_passes(scene, condition) if step.needed
        ]
        for name in protocol.scenes
        for scene in [load_scene(protocol.scene_source(name))]
        for condition in protocol.conditions
    }
    return Machine(
        gpu=facts["renderer"],
        driver=facts["version"],
        runtime="playback",
        shaders=shader_hashes(),
        passes=passes,
        text_layout=layout_facts(),
        stimulus_version=STIMULUS_VERSION,
        timing_trust=TimingTrust.LOCKSTEP,
    )


def shader_hashes() -> dict[str, str]:
    """Return file → SHA-256 of the shaders."""
    folder = data_folder("shaders")
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): sha256_of(path) for path in files}
