"""Interaction profiles of OpenXR: the inputs that choose, stop and walk on each controller.

One table, from which the bindings are suggested, and the documentation and `doctor` list them. It
has every profile of the specification's registry for ``/user/hand/left`` and ``right`` that a
program of OpenXR 1.0 can suggest bindings for (`tests/data/openxr_profiles.json` has the
registry's list of inputs).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

HANDS = ("left", "right")
Inputs = Mapping[str, str]
"""Action → its input, below ``/user/hand/<hand>/input/``."""


@dataclass(frozen=True)
class Profile:
    """The suggested bindings of one interaction profile.

    Parameters
    ----------
    path
        The profile, below ``/interaction_profiles/``.
    name
        Of the controllers, for people.
    left, right
        The hands' own inputs; the aim that all have, and the vibration, come on top.
    extension
        What must be switched on for it.
    ticks
        Whether it can vibrate: bare hands cannot.
    """

    path: str
    name: str
    left: Inputs
    right: Inputs
    extension: str | None = None
    ticks: bool = True

    def own(self, hand: str) -> Inputs:
        """Return the inputs of a hand ("left", "right")."""
        return self.left if hand == "left" else self.right

    def pairs(self) -> list[tuple[str, str]]:
        """Return (action, full path) of each binding."""
        return [
            (action, f"/user/hand/{hand}/{place}")
            for hand in HANDS
            for action, place in self._places(hand)
        ]

    def _places(self, hand: str) -> list[tuple[str, str]]:
        own = [(action, f"input/{place}") for action, place in self.own(hand).items()]
        tick = [("haptic", "output/haptic")] if self.ticks else []
        return [("aim", "input/aim/pose"), *tick, *own]

    def words(self, action: str) -> str:
        """Return the inputs of an action, in words: for each hand where they differ."""
        left, right = (_in_words(self.own(hand).get(action)) for hand in HANDS)
        if action == "stop" and "fist" in self.left:
            return "both fists, or one for 2 s"
        return left if left == right else f"{left} (left), {right} (right)"

    def stops(self, hand: str) -> str:
        """Return the input that stops an exposure with one hand alone, in words."""
        own = self.own(hand)
        return "a fist for 2 s" if "fist" in own else _in_words(own.get("stop"))


_WORDS = {
    "a": "A", "b": "B", "y": "Y", "thumbstick": "thumb-stick", "trackpad": "track-pad",
    "squeeze": "grip", "shoulder": "bumper", "aim_activate_ext": "the runtime's gesture",
    "cluster_front_logitech": "front button", "cluster_back_logitech": "back button",
}  # fmt: skip


def _in_words(place: str | None) -> str:
    """Return an input as people call it."""
    if place is None:
        return "–"
    part, _, component = place.partition("/")
    words = _WORDS.get(part, part.replace("_", " "))
    return f"press of the {words}" if part == "trackpad" and component == "click" else words


def _inputs(select: str, back: str | None, stop: str, move: str | None) -> dict[str, str]:
    told = {"select": select, "back": back, "stop": stop, "move": move}
    return {action: place for action, place in told.items() if place}


_STICK, _PAD = "thumbstick", "trackpad"
_CLICK, _VALUE, _MENU = "trigger/click", "trigger/value", "menu/click"
_SIMPLE = _inputs("select/click", None, _MENU, None)
_XY = _inputs(_VALUE, "y/click", _MENU, _STICK)
_AB = _inputs(_VALUE, "b/click", "a/click", _STICK)
_XY_CLICK, _AB_CLICK = _XY | {"select": _CLICK}, _AB | {"select": _CLICK}
_AB_MENU = _AB | {"stop": _MENU}
_INDEX = _AB | {"select": _CLICK}
_VIVE = _inputs(_CLICK, "squeeze/click", _MENU, _PAD)
_WMR = _inputs(_VALUE, "squeeze/click", _MENU, _STICK)
_BARE = {"select": "aim_activate_ext/value", "fist": "grasp_ext/value"}
_BARE_MSFT = {"select": "select/value", "fist": "squeeze/value"}
_BACK_AND_PAD = _inputs(_CLICK, None, "back/click", _PAD)
_DAYDREAM = _inputs("select/click", None, "trackpad/click", None)
_G3 = _inputs(_CLICK, None, _MENU, _STICK)
_ML2 = _inputs(_CLICK, "shoulder/click", _MENU, _PAD)
_STYLUS = _inputs("cluster_front_logitech/click", None, "cluster_back_logitech/click", None)
_GENERIC = _inputs(_VALUE, "secondary/click", "primary/click", _STICK)
_PICO = "XR_BD_controller_interaction"

_HTC, _CONTROLLER = "XR_HTC", "_controller_interaction"

PROFILES = (
    Profile("khr/simple_controller", "any other (khr/simple)", _SIMPLE, _SIMPLE),
    Profile("oculus/touch_controller", "Oculus / Meta Touch", _XY, _AB),
    Profile("valve/index_controller", "Valve Index", _INDEX, _INDEX),
    Profile("htc/vive_controller", "Vive", _VIVE, _VIVE),
    Profile("microsoft/motion_controller", "Windows Mixed Reality", _WMR, _WMR),
    Profile("oculus/go_controller", "Oculus Go", _BACK_AND_PAD, _BACK_AND_PAD, ticks=False),
    Profile("google/daydream_controller", "Daydream", _DAYDREAM, _DAYDREAM, ticks=False),
    Profile(
        "facebook/touch_controller_pro", "Meta Touch Pro", _XY, _AB, "XR_FB_touch_controller_pro"
    ),
    Profile(
        "meta/touch_controller_plus", "Meta Touch Plus", _XY, _AB, "XR_META_touch_controller_plus"
    ),
    Profile(
        "hp/mixed_reality_controller", "HP", _XY, _AB_MENU, "XR_EXT_hp_mixed_reality_controller"
    ),
    Profile(
        "samsung/odyssey_controller",
        "Samsung Odyssey",
        _WMR,
        _WMR,
        "XR_EXT_samsung_odyssey_controller",
    ),
    Profile(
        "htc/vive_cosmos_controller",
        "Vive Cosmos",
        _XY_CLICK,
        _AB_CLICK,
        f"{_HTC}_vive_cosmos{_CONTROLLER}",
    ),
    Profile(
        "htc/vive_focus3_controller",
        "Vive Focus 3",
        _XY_CLICK,
        _AB_CLICK,
        f"{_HTC}_vive_focus3{_CONTROLLER}",
    ),
    Profile("bytedance/pico4_controller", "Pico 4", _XY, _AB, f"XR_BD{_CONTROLLER}"),
    Profile("bytedance/pico_neo3_controller", "Pico Neo 3", _XY, _AB_MENU, f"XR_BD{_CONTROLLER}"),
    Profile(
        "bytedance/pico_g3_controller", "Pico G3", _G3, _G3, f"XR_BD{_CONTROLLER}", ticks=False
    ),
    Profile(
        "bytedance/pico_ultra_controller_bd", "Pico 4 Ultra", _XY, _AB, f"XR_BD_ultra{_CONTROLLER}"
    ),
    Profile("ml/ml2_controller", "Magic Leap 2", _ML2, _ML2, f"XR_ML_ml2{_CONTROLLER}"),
    Profile("oppo/mr_controller_oppo", "Oppo MR", _XY, _AB, f"XR_OPPO{_CONTROLLER}"),
    Profile("yvr/touch_controller_yvr", "YVR", _XY, _AB, f"XR_YVR{_CONTROLLER}"),
    Profile("varjo/xr-4_controller", "Varjo XR-4", _AB, _AB, f"XR_VARJO_xr4{_CONTROLLER}"),
    Profile("huawei/controller", "Huawei", _BACK_AND_PAD, _BACK_AND_PAD, f"XR_HUAWEI{_CONTROLLER}"),
    Profile(
        "logitech/mx_ink_stylus_logitech",
        "Logitech MX Ink",
        _STYLUS,
        _STYLUS,
        "XR_LOGITECH_mx_ink_stylus_interaction",
    ),
    Profile(
        "khr/generic_controller",
        "generic (khr/generic)",
        _GENERIC,
        _GENERIC,
        "XR_KHR_generic_controller",
    ),
    Profile(
        "ext/hand_interaction_ext",
        "bare hands (`XR_EXT_hand_interaction`)",
        _BARE,
        _BARE,
        "XR_EXT_hand_interaction",
        ticks=False,
    ),
    Profile(
        "microsoft/hand_interaction",
        "bare hands (`XR_MSFT_hand_interaction`)",
        _BARE_MSFT,
        _BARE_MSFT,
        "XR_MSFT_hand_interaction",
        ticks=False,
    ),
)
"""``stop`` is the menu button where an application may have it, else A: on the Index, and on right
controllers whose menu button is the runtime's. Bare hands have none: two fists stop, or one that is
held."""

EXTENSIONS = tuple(dict.fromkeys(each.extension for each in PROFILES if each.extension))


def profile_of(path: str) -> Profile | None:
    """Return the profile of a path such as ``/interaction_profiles/valve/index_controller``."""
    return next((each for each in PROFILES if path.endswith(f"/{each.path}")), None)


def stop_of(path: str, hand: str) -> str:
    """Return the input that stops an exposure with one hand alone, by the path of its profile."""
    profile = profile_of(path)
    return "nothing" if profile is None else profile.stops(hand)


TABLE_HEAD = ("controller", "choose", "back", "stop", "walk")


def table() -> list[tuple[str, ...]]:
    """Return the rows of the table for people, controllers that are alike in one."""
    rows: dict[tuple[str, ...], list[str]] = {}
    for each in PROFILES:
        does = tuple(each.words(action) for action in ("select", "back", "stop", "move"))
        rows.setdefault(does, []).append(each.name)
    return [(", ".join(names), *does) for does, names in rows.items()]
