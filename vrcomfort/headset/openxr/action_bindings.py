"""Which buttons mean what, on each controller that OpenXR knows."""

from __future__ import annotations

from dataclasses import dataclass

import xr

HANDS = ("left", "right")
BOTH = {"aim": "input/aim/pose", "haptic": "output/haptic"}


@dataclass(frozen=True)
class Profile:
    """The suggested bindings of one interaction profile.

    Parameters
    ----------
    path
        The profile, below ``/interaction_profiles/``.
    left, right
        Action to input or output path, below ``/user/hand/<hand>/``; the poses and the vibration
        that all controllers share come on top.
    extension
        What must be switched on for it.
    ticks
        Whether it can vibrate: bare hands cannot.
    """

    path: str
    left: dict[str, str]
    right: dict[str, str]
    extension: str | None = None
    ticks: bool = True

    def pairs(self) -> list[tuple[str, str]]:
        """Return (action, full path) of each binding."""
        return [
            (action, f"/user/hand/{hand}/{place}")
            for hand, own in zip(HANDS, (self.left, self.right), strict=True)
            for action, place in {**BOTH, **own}.items()
            if self.ticks or action != "haptic"
        ]


_TRIGGER = {"select": "input/trigger/value", "move": "input/thumbstick"}
_XY = {**_TRIGGER, "back": "input/y/click", "stop": "input/menu/click"}
_AB = {**_TRIGGER, "back": "input/b/click", "stop": "input/a/click"}
_SIMPLE = {"select": "input/select/click", "stop": "input/menu/click"}
_INDEX = {
    "select": "input/trigger/click",
    "back": "input/b/click",
    "stop": "input/a/click",
    "move": "input/thumbstick",
}
_VIVE = {
    "select": "input/trigger/click",
    "back": "input/squeeze/click",
    "stop": "input/menu/click",
    "move": "input/trackpad",
}
_WMR = {**_TRIGGER, "back": "input/squeeze/click", "stop": "input/menu/click"}
_HP = {"stop": "input/menu/click"}
_FOCUS3 = {"select": "input/trigger/click"}
_BARE = {"select": "input/aim_activate_ext/value", "fist": "input/grasp_ext/value"}
_NEO3 = {"stop": "input/menu/click"}

PROFILES = (
    Profile("khr/simple_controller", _SIMPLE, _SIMPLE),
    Profile("oculus/touch_controller", _XY, _AB),
    Profile("valve/index_controller", _INDEX, _INDEX),
    Profile("htc/vive_controller", _VIVE, _VIVE),
    Profile("microsoft/motion_controller", _WMR, _WMR),
    Profile(
        "hp/mixed_reality_controller",
        _XY,
        _AB | _HP,
        xr.EXT_HP_MIXED_REALITY_CONTROLLER_EXTENSION_NAME,
    ),
    Profile(
        "htc/vive_focus3_controller",
        _XY | _FOCUS3,
        _AB | _FOCUS3,
        xr.HTC_VIVE_FOCUS3_CONTROLLER_INTERACTION_EXTENSION_NAME,
    ),
    Profile("bytedance/pico4_controller", _XY, _AB, xr.BD_CONTROLLER_INTERACTION_EXTENSION_NAME),
    Profile(
        "bytedance/pico_neo3_controller",
        _XY,
        _AB | _NEO3,
        xr.BD_CONTROLLER_INTERACTION_EXTENSION_NAME,
    ),
    Profile(
        "ext/hand_interaction_ext",
        _BARE,
        _BARE,
        xr.EXT_HAND_INTERACTION_EXTENSION_NAME,
        ticks=False,
    ),
)
"""``stop`` is the menu button where an application may have it, else A: on the Index, and on right
controllers whose menu button is the runtime's. Bare hands have none, and stop with two fists."""

GAZE_PROFILE = "ext/eye_gaze_interaction"
GAZE_PATH = "/user/eyes_ext/input/gaze_ext/pose"
