"""Calls into OpenXR: watched, fast for every frame, and with poses in our types."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from operator import attrgetter
from typing import Any, TypeVar

import xr

from vrcomfort.geometry import Fov, Pose, View
from vrcomfort.headset.watchdog import RUNTIME_CALLS

Call = Callable[..., int]
Result = TypeVar("Result")


def native(name: str, *, usual: xr.Result = xr.Result.SUCCESS) -> Call:
    """Return a function that takes structures made beforehand, and returns its result code.

    pyopenxr's wrappers make structures, an enumeration and an exception for every call.

    Parameters
    ----------
    usual
        A result besides success that is returned; the function raises what pyopenxr would raise
        for any other.
    """
    return _in_sight(name, _raw(name), int(usual))


def native_extension(instance: xr.Instance, name: str) -> Call:
    """Return such a function of an extension, which the loader finds when it is asked for."""
    address = watched(xr.get_instance_proc_addr, instance, name)
    return _in_sight(name, ctypes.cast(address, getattr(xr, f"PFN_{name}")), 0)


def raw_field(structure: type[ctypes.Structure], name: str) -> Callable[[Any], Any]:
    """Return a function that reads a field as C has it.

    Some versions of pyopenxr call the field `name`, others ``_name`` beside a property of that
    name, which converts: making an enumeration costs 10 µs.
    """
    fields = {field[0] for each in structure.__mro__ for field in vars(each).get("_fields_", ())}
    return attrgetter(next(each for each in (name, f"_{name}") if each in fields))


def _in_sight(name: str, function: Call, expected: int) -> Call:
    """Return a call in sight of the watchdog."""
    begin, end = RUNTIME_CALLS.begin, RUNTIME_CALLS.end

    def call(*arguments: Any) -> int:
        begin(name)
        try:
            result = function(*arguments)
        finally:
            end()
        if result not in {0, expected}:
            check(result)
        return result

    return call


def watched(function: Callable[..., Result], *arguments: Any) -> Result:
    """Call one of pyopenxr's functions, in sight of the watchdog."""
    words = function.__name__.split("_")
    RUNTIME_CALLS.begin("xr" + "".join(word.capitalize() for word in words))
    try:
        return function(*arguments)
    finally:
        RUNTIME_CALLS.end()


def check(result: int) -> None:
    """Raise pyopenxr's exception for a raw function's result code."""
    checked = xr.check_result(xr.Result(result))
    if checked.is_exception():
        raise checked


def _raw(name: str) -> Call:
    """Return the loader's function, by pyopenxr's own description of its arguments."""
    function: Any = xr.raw_functions.openxr_loader_library[name]
    function.argtypes = getattr(xr.raw_functions, name).argtypes
    function.restype = ctypes.c_int32
    return function  # type: ignore[no-any-return]


def pose_from_xr(pose: xr.Posef) -> Pose:
    """Return the same pose in float64."""
    p, q = pose.position, pose.orientation
    return Pose.of((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def pose_to_xr(pose: Pose) -> xr.Posef:
    """Return the same pose, rounded to float32."""
    return xr.Posef(
        orientation=xr.Quaternionf(*map(float, pose.orientation)),
        position=xr.Vector3f(*map(float, pose.position)),
    )


def view_from_xr(view: xr.View) -> View:
    """Return an eye's pose and frustum."""
    fov = view.fov
    angles = Fov(fov.angle_left, fov.angle_right, fov.angle_up, fov.angle_down)
    return View(pose_from_xr(view.pose), angles)
