"""What each hand can do on every controller, and that the documentation tells the same."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import pytest

pytest.importorskip("xr", reason="pyopenxr is not installed")

from vrcomfort.headset.openxr.actions import HANDS, PROFILES, Profile

HAND_OF = list(product(PROFILES, HANDS))
NAMES = [f"{profile.path} {hand}" for profile, hand in HAND_OF]
DOCUMENTED = {
    "oculus/touch_controller": "Oculus / Meta Touch",
    "bytedance/pico4_controller": "Pico 4",
    "htc/vive_focus3_controller": "Vive Focus 3",
    "hp/mixed_reality_controller": "HP",
    "bytedance/pico_neo3_controller": "Pico Neo 3",
    "valve/index_controller": "Valve Index",
    "htc/vive_controller": "Vive",
    "microsoft/motion_controller": "Windows Mixed Reality",
    "khr/simple_controller": "any other (khr/simple)",
    "ext/hand_interaction_ext": "bare hands (`XR_EXT_hand_interaction`)",
}
WORDS = {
    "trigger": "trigger", "select": "select", "b": "B", "y": "Y", "a": "A", "menu": "menu",
    "squeeze": "grip", "grasp_ext": "both fists", "thumbstick": "thumb-stick",
    "trackpad": "track-pad", "aim_activate_ext": "the runtime's gesture",
}  # fmt: skip
"""Inputs as the documentation calls them."""


def own(profile: Profile, hand: str) -> dict[str, str]:
    return profile.left if hand == "left" else profile.right


def rows_of_the_page() -> dict[str, list[str]]:
    page = Path(__file__).parent.parent / "docs" / "openxr.md"
    rows = [line.strip("| ").split(" | ") for line in page.read_text("utf-8").splitlines()]
    table = {row[0]: row[1:] for row in rows if len(row) == 5}
    return {name: cells for names, cells in table.items() for name in re.split(r", ", names)}


@pytest.mark.parametrize(("profile", "hand"), HAND_OF, ids=NAMES)
def test_each_hand_answers_and_asks_to_stop(profile: Profile, hand: str) -> None:
    can = own(profile, hand)
    assert "select" in can
    both_fists = "fist" in profile.left and "fist" in profile.right
    assert "stop" in can or both_fists


@pytest.mark.parametrize(("profile", "hand"), HAND_OF, ids=NAMES)
def test_no_input_means_two_things(profile: Profile, hand: str) -> None:
    inputs = [path.split("/")[1] for path in own(profile, hand).values()]
    assert len(set(inputs)) == len(inputs)


@pytest.mark.parametrize("profile", PROFILES, ids=lambda profile: profile.path)
def test_the_documentation_tells_the_same(profile: Profile) -> None:
    choose, back, stop, walk = rows_of_the_page()[DOCUMENTED[profile.path]]
    for action, cell in (("select", choose), ("back", back), ("move", walk)):
        bound = [own(profile, hand).get(action) for hand in HANDS]
        named = [WORDS[path.split("/")[1]] for path in bound if path]
        assert all(word in cell for word in named), (action, cell)
        assert bool(named) == (cell != "–")
    left, right = (own(profile, h).get("stop") or own(profile, h)["fist"] for h in HANDS)
    left, right = (WORDS[path.split("/")[1]] for path in (left, right))
    assert stop == (left if left == right else f"{left} (left), {right} (right)")
