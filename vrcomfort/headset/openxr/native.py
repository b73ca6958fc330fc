"""OpenXR's functions for every frame: no new structures, no exceptions for what is usual."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import xr

from vrcomfort.headset.openxr.instance import check

Call = Callable[..., int]


def native(name: str, *, usual: xr.Result = xr.Result.SUCCESS) -> Call:
    """Return a function that takes structures made beforehand, and returns its result code.

    pyopenxr's wrappers make structures, an enumeration and an exception for every call.

    Parameters
    ----------
    usual
        A result besides success that is returned; the function raises what pyopenxr would raise
        for any other.
    """
    function, expected = _raw(name), int(usual)

    def call(*arguments: Any) -> int:
        result = function(*arguments)
        if result not in {0, expected}:
            check(result)
        return result

    return call


def _raw(name: str) -> Call:
    """Return the loader's function, by pyopenxr's own description of its arguments."""
    function: Any = xr.raw_functions.openxr_loader_library[name]
    function.argtypes = getattr(xr.raw_functions, name).argtypes
    function.restype = ctypes.c_int32
    return function  # type: ignore[no-any-return]
