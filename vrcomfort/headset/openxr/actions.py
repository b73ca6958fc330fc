"""Controllers, hands and eyes: bindings, buttons, thumb-sticks, aim, vibration and gaze."""

from __future__ import annotations

import ctypes
from contextlib import suppress
from dataclasses import replace
from typing import Any

import xr

from vrcomfort.geometry import EyeGaze, Pose, normalize, turn_to
from vrcomfort.headset.inputs import HandInput, Inputs, SeenGaze
from vrcomfort.headset.openxr.instance import Runtime
from vrcomfort.headset.openxr.native import check, native, native_extension, pose_from_xr, watched
from vrcomfort.headset.openxr.profiles import HANDS, PROFILES
from vrcomfort.headset.openxr.spaces import LOCATION_FLAGS, VALID, Stage

GAZE_PROFILE = "ext/eye_gaze_interaction"
GAZE_PATH = "/user/eyes_ext/input/gaze_ext/pose"


# Of the extensions that pyopenxr knows this is the only one on a PC that tells the eyes apart; none
# tells the size of the pupils.
EACH_EYE_EXTENSION = xr.FB_EYE_TRACKING_SOCIAL_EXTENSION_NAME

EyeGazes = tuple[EyeGaze, EyeGaze]
"""The left and the right one."""


class EachEye:
    """The eye tracker of a session.

    Parameters
    ----------
    instance, session
        OpenXR's handles; the extension is switched on.
    """

    def __init__(self, instance: xr.Instance, session: xr.Session) -> None:
        self._tracker = watched(xr.create_eye_tracker_fb, session, xr.EyeTrackerCreateInfoFB())
        self._get = native_extension(instance, "xrGetEyeGazesFB")
        self._info, self._found = xr.EyeGazesInfoFB(), xr.EyeGazesFB()  # made once: hot

    def read(self, space: xr.Space, time_ns: int) -> tuple[EyeGazes, int]:
        """Return both eyes in a space, and when the tracker saw them (0: it does not say)."""
        self._info.base_space, self._info.time = space, time_ns
        self._get(self._tracker, ctypes.byref(self._info), ctypes.byref(self._found))
        return eyes_from_xr(self._found), int(self._found.time)

    def release(self) -> None:
        """Destroy the tracker."""
        with suppress(xr.exception.ResultException):
            watched(xr.destroy_eye_tracker_fb, self._tracker)


def eyes_from_xr(found: xr.EyeGazesFB) -> EyeGazes:
    """Return the gazes that a tracker has found."""
    left, right = (
        EyeGaze(pose_from_xr(eye.gaze_pose)) if eye.is_valid else EyeGaze(Pose(), valid=False)
        for eye in found.gaze
    )
    return left, right


def combined_gaze(eyes: EyeGazes, time_ns: int) -> SeenGaze:
    """Return where both eyes look: from between them, along the mean of their directions.

    For runtimes that tell of each eye alone. It is valid where both eyes are seen.
    """
    left, right = eyes
    if not (left.valid and right.valid):
        return SeenGaze(Pose(), valid=False, eyes=eyes, time_ns=time_ns)
    between = (left.pose.position + right.pose.position) / 2
    along = normalize(left.pose.forward + right.pose.forward)
    return SeenGaze(Pose(between, turn_to(along)), eyes=eyes, time_ns=time_ns)


TICK_NS = 30_000_000
TICK_AMPLITUDE = 0.4
TRACKED = VALID | int(xr.SpaceLocationFlags.ORIENTATION_TRACKED_BIT)

_KINDS = {
    "select": xr.ActionType.BOOLEAN_INPUT,
    "back": xr.ActionType.BOOLEAN_INPUT,
    "stop": xr.ActionType.BOOLEAN_INPUT,
    "fist": xr.ActionType.BOOLEAN_INPUT,
    "move": xr.ActionType.VECTOR2F_INPUT,
    "aim": xr.ActionType.POSE_INPUT,
    "haptic": xr.ActionType.VIBRATION_OUTPUT,
}


class Actions:
    """The one action set of a study, attached to the session.

    Parameters
    ----------
    runtime, session
        Whose controllers.

    Attributes
    ----------
    reached
        Whether the controllers were the session's when it last took their state: a menu of the
        runtime's may have them before the runtime has told of it.
    """

    def __init__(self, runtime: Runtime, session: xr.Session) -> None:
        self._runtime, self._session = runtime, session
        self.reached = False
        self._set = watched(
            xr.create_action_set, runtime.instance, xr.ActionSetCreateInfo("study", "Study", 0)
        )
        self._hands = [self._path(f"/user/hand/{hand}") for hand in HANDS]
        self._actions = {name: self._make(name, kind) for name, kind in _KINDS.items()}
        self._gaze = self._make_gaze() if runtime.has_gaze else None
        self._each_eye = EachEye(runtime.instance, session) if runtime.has_each_eye else None
        self._suggest()
        watched(
            xr.attach_session_action_sets,
            session,
            xr.SessionActionSetsAttachInfo(action_sets=[self._set]),
        )
        self._get = {  # made once: hot
            (name, hand): xr.ActionStateGetInfo(action=action, subaction_path=path)
            for name, action in self._actions.items()
            for hand, path in enumerate(self._hands)
        }
        self._sync = native("xrSyncActions", usual=xr.Result.SESSION_NOT_FOCUSED)
        self._state_of_pose = native("xrGetActionStatePose")
        self._state_of_stick = native("xrGetActionStateVector2f")
        self._state_of_button = native("xrGetActionStateBoolean")
        self._pose, self._stick = xr.ActionStatePose(), xr.ActionStateVector2f()
        self._button = xr.ActionStateBoolean()
        self._aims = [self._space(self._actions["aim"], hand) for hand in self._hands]
        self._gaze_space = None if self._gaze is None else self._space(self._gaze)
        self._sync_info = xr.ActionsSyncInfo(active_action_sets=[xr.ActiveActionSet(self._set, 0)])

    def sync(self) -> None:
        """Take the state of all buttons, once per frame."""
        self.reached = self._sync(self._session, self._sync_info) == 0  # else they read as inactive

    def read(self, stage: Stage, time_ns: int) -> Inputs:
        """Return the inputs of hands and eyes at `time_ns`."""
        left, right = (self._hand(hand, stage, time_ns) for hand in (0, 1))
        return Inputs(left, right, self._read_gaze(stage, time_ns))

    def tick(self, hand: int) -> None:
        """Let controller `hand` (0 left, 1 right) tick, to confirm an answer."""
        info = xr.HapticActionInfo(self._actions["haptic"], self._hands[hand])
        pulse = xr.HapticVibration(
            duration=TICK_NS, frequency=xr.FREQUENCY_UNSPECIFIED, amplitude=TICK_AMPLITUDE
        )
        with suppress(xr.exception.SessionNotFocused):  # the runtime's own menu has the controllers
            watched(xr.apply_haptic_feedback, self._session, info, pulse)

    def profile(self, hand: int) -> str:
        """Return which controller the runtime uses for `hand`, or an empty string."""
        state = watched(xr.get_current_interaction_profile, self._session, self._hands[hand])
        profile = state.interaction_profile
        return xr.path_to_string(self._runtime.instance, profile) if profile else ""

    def release(self) -> None:
        """Destroy the action set, with its actions and spaces."""
        if self._each_eye is not None:
            self._each_eye.release()
        watched(xr.destroy_action_set, self._set)

    def _hand(self, hand: int, stage: Stage, time_ns: int) -> HandInput:
        self._state_of_pose(self._session, self._get["aim", hand], self._pose)
        self._state_of_stick(self._session, self._get["move", hand], self._stick)
        stick = self._stick.current_state
        held, select = self._pressed("select", hand)
        fist, closed = self._pressed("fist", hand)
        return HandInput(
            aim=stage.locate(self._aims[hand], time_ns) if self._pose.is_active else None,
            select=select,
            back=self._pressed("back", hand)[1],
            stop=self._pressed("stop", hand)[1],
            held=held,
            fist=fist,
            closed=closed,
            thumbstick=(stick.x, stick.y),
        )

    def _pressed(self, name: str, hand: int) -> tuple[bool, bool]:
        """Return whether a button is down, and whether it has gone down since the last `sync`."""
        state = self._button
        self._state_of_button(self._session, self._get[name, hand], state)
        down = bool(state.current_state)
        return down, down and bool(state.changed_since_last_sync)

    def _read_gaze(self, stage: Stage, time_ns: int) -> SeenGaze | None:
        combined = self._read_combined(stage, time_ns)
        if self._each_eye is None:
            return combined
        eyes, seen_ns = self._each_eye.read(stage.space, time_ns)
        return combined_gaze(eyes, seen_ns) if combined is None else replace(combined, eyes=eyes)

    def _read_combined(self, stage: Stage, time_ns: int) -> SeenGaze | None:
        if self._gaze_space is None:
            return None
        seen = xr.EyeGazeSampleTimeEXT()
        location = xr.SpaceLocation(next=seen)
        locate = xr.raw_functions.xrLocateSpace
        check(locate(self._gaze_space, stage.space, time_ns, ctypes.byref(location)))
        flags = LOCATION_FLAGS(location)
        if flags & VALID != VALID:
            return SeenGaze(Pose(), valid=False, time_ns=int(seen.time))
        pose = pose_from_xr(location.pose)
        return SeenGaze(pose, flags & TRACKED == TRACKED, time_ns=int(seen.time))

    def _make(self, name: str, kind: xr.ActionType) -> xr.Action:
        return watched(
            xr.create_action,
            self._set,
            xr.ActionCreateInfo(
                name,
                kind,
                subaction_paths=self._hands,
                localized_action_name=name.capitalize(),
            ),
        )

    def _make_gaze(self) -> xr.Action:
        info = xr.ActionCreateInfo("gaze", xr.ActionType.POSE_INPUT, localized_action_name="Gaze")
        return watched(xr.create_action, self._set, info)

    def _suggest(self) -> None:
        for profile in PROFILES:
            if profile.extension is None or profile.extension in self._runtime.extensions:
                pairs = [(self._actions[name], path) for name, path in profile.pairs()]
                # An older version of the extension may not have it: there is no such controller.
                with suppress(xr.exception.PathUnsupportedError):
                    self._suggest_profile(profile.path, pairs)
        if self._gaze is not None:
            self._suggest_profile(GAZE_PROFILE, [(self._gaze, GAZE_PATH)])

    def _suggest_profile(self, profile: str, pairs: list[tuple[Any, str]]) -> None:
        suggested = [xr.ActionSuggestedBinding(each, self._path(path)) for each, path in pairs]
        watched(
            xr.suggest_interaction_profile_bindings,
            self._runtime.instance,
            xr.InteractionProfileSuggestedBinding(
                interaction_profile=self._path(f"/interaction_profiles/{profile}"),
                suggested_bindings=suggested,
            ),
        )

    def _space(self, action: xr.Action, hand: int = xr.NULL_PATH) -> xr.Space:
        info = xr.ActionSpaceCreateInfo(action=action, subaction_path=hand)
        return watched(xr.create_action_space, self._session, info)

    def _path(self, text: str) -> int:
        path: int = xr.string_to_path(self._runtime.instance, text)
        return path
