"""What each hand can do on every controller: as the registry has it, and the documentation."""

from __future__ import annotations

import json
from itertools import product

import pytest

from tests.support.places import ROOT

pytest.importorskip("xr", reason="pyopenxr is not installed")

from scripts import controllers_table
from vrcomfort.headset.openxr.profiles import HANDS, PROFILES, profile_of, stop_of

REGISTRY = json.loads((ROOT / "tests/data/openxr_profiles.json").read_text("utf-8"))["profiles"]


def test_every_profile_of_the_registry_is_bound() -> None:
    of_1_1 = {name for name, each in REGISTRY.items() if each["of"] == ["XR_VERSION_1_1"]}
    assert {profile.path for profile in PROFILES} == REGISTRY.keys() - of_1_1
    assert all("touch" in name for name in of_1_1)  # which 1.0 has as one


def test_a_profile_is_asked_for_by_its_extension() -> None:
    for profile in PROFILES:
        of = REGISTRY[profile.path]["of"]
        assert (profile.extension or "XR_VERSION_1_0") in of, profile.path


def test_what_is_bound_is_there_and_the_programs() -> None:
    for profile in PROFILES:
        for _, path in profile.pairs():
            _, _, _, hand, place = path.split("/", 4)
            inputs = set(REGISTRY[profile.path][hand])
            assert place in inputs or f"{place}/x" in inputs, (profile.path, path)


def test_each_hand_answers_and_asks_to_stop_by_inputs_that_mean_one_thing() -> None:
    for profile, hand in product(PROFILES, HANDS):
        can = profile.own(hand)
        assert "select" in can, (profile.path, hand)
        assert "stop" in can or "fist" in can, (profile.path, hand)
        assert stop_of(f"/interaction_profiles/{profile.path}", hand) != "–"
        inputs = [place.split("/")[0] for place in can.values()]
        assert len(set(inputs)) == len(inputs), (profile.path, hand)


def test_a_profile_is_found_by_its_whole_path() -> None:
    found = profile_of("/interaction_profiles/valve/index_controller")
    assert found is not None
    assert found.stops("left") == "A"
    assert profile_of("") is None
    assert stop_of("/interaction_profiles/other/controller", "left") == "nothing"


def test_the_documentation_tells_the_same() -> None:
    page = controllers_table.PAGE.read_text("utf-8")
    shown = page.partition(controllers_table.FROM)[2].partition(controllers_table.TO)[0]
    assert shown == controllers_table.markdown(), "run python scripts/controllers_table.py"
