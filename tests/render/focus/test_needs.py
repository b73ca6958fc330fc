"""A setting of the focus does something exactly where a protocol may write it down."""

import numpy as np
import pytest

from tests.support.render import at, glowing, scene, wall
from vrcomfort.geometry import Gaze, Pose, yaw_pitch_roll
from vrcomfort.protocol.condition_check import NEEDS
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.rules import make_focus_pass
from vrcomfort.render.focus.search import HeadView
from vrcomfort.render.gpu_scene import GpuScene

OTHER = {
    "fixed_m": 3.0,
    "script": ((0.0, 3.0), (1.0, 0.5)),
    "script_every_s": 1.1,
    "ring_deg": 4.0,
    "mean": "dioptres",
    "outlier_mad": 0.1,
    "outlier_floor_fraction": 0.9,
    "outlier_floor_dioptre": 0.9,
    "zone_ratio": 0.5,
    "zone_size_px": (9, 7),
    "zone_statistic": "minimum",
    "semantic_min": 1.0,
    "semantic_max": 0.004,
    "gauss_centre": 0.9,
    "gauss_border": 0.2,
    "gaze_radius_deg": 9.0,
    "law": "low_pass_backward_euler",
    "refocus_s": 0.7,
    "cutoff_hz": 3.0,
    "duration_s": 0.9,
    "refixation_dioptre": 0.4,
}
"""Another value of every setting but of those in `OTHERWISE`."""
OTHERWISE = {"zone_mean_on", "without_gaze", "scripts"}
"""Who computes the same, what is done without an eye tracker, and what takes `script`'s place."""

BASES = [
    *({"method": method, "law": "instant"} for method in ("fixed", "gaze")),
    {"method": "scripted", "script": ((0.0, 2.0), (1.0, 0.5)), "law": "instant"},
    *({"method": "nine_ray", "mean": mean} for mean in ("metres", "dioptres")),
    *(
        {"method": "autofocus_zone", "law": "instant", "zone_statistic": statistic}
        for statistic in ("mean", "minimum", "maximum")
    ),
    *(
        {"law": law, "mean": "dioptres", "ring_deg": 12.0, "outlier_mad": 0.5}
        for law in ("linear_dioptre", "low_pass", "duration", "instant")
    ),
]


@pytest.fixture(scope="module")
def content():
    """Slanted boards at many distances and of many weights, before a wall."""
    random = np.random.default_rng(8)
    boards = [
        at(
            *random.uniform(-0.5, 0.5, 2),
            -random.uniform(0.5, 4.0),
            scale=np.full(3, 0.25),
            rotation=yaw_pitch_roll(*random.uniform(-0.9, 0.9, 3)),
            semantic_weight=random.choice([0.004, 0.02, 0.2, 1.0]),
        )
        for _ in range(40)
    ]
    behind = at(0.0, 0.0, -6.0, scale=np.full(3, 90.0))
    before = at(0.05, 0.05, -0.45, scale=np.full(3, 0.02))  # of the least weight
    return scene([behind, before, *boards], [wall()], [glowing((1.0, 1.0, 1.0), double_sided=True)])


def course(ctx, content, settings):
    """Focus in frames 1 µs and 10 ms apart, from a head that moves, in a scene that is faster."""
    gpu = GpuScene(ctx, content)
    focus = make_focus_pass(ctx, gpu, settings)
    samples = []
    for index, time_ns in enumerate([0, 1_000, 2_000, 10_000_000, 20_000_000]):
        angles = yaw_pitch_roll(0.06 * index - 0.1, 0.03 * index, 0.0)
        head = Pose(np.array([0.02 * index, 0.0, 0.04 * index]), angles)
        gpu.update(0.0, head)
        gaze = Gaze(Pose(np.zeros(3), yaw_pitch_roll(0.1, 0.05 * index, 0.0)))
        sight = HeadView(index, time_ns, head, gaze=gaze, scene_time_s=0.4 * index)
        samples += focus.render(sight)
    return [sample.focus_m for sample in (*samples, *focus.drain())]


def test_every_setting_with_needs_is_tried():
    assert OTHER.keys() | OTHERWISE == NEEDS["focus"].keys()


@pytest.mark.parametrize("base", BASES, ids=lambda base: "-".join(map(str, base.values())))
def test_a_setting_does_something_where_its_needs_are_met_and_nothing_elsewhere(ctx, content, base):
    usual = course(ctx, content, Focus(**base))
    for key, value in OTHER.items():
        if base.get(key) == value:
            continue
        settings = Focus(**base)
        met = all(getattr(settings, name) in of for name, of in NEEDS["focus"][key].items())
        changed = course(ctx, content, Focus(**{**base, key: value}))
        assert (changed != usual) == met, (key, base)
