"""An OpenXR API layer written in Python: listens to calls on their way to the runtime, or bends
their answers. Runtimes refuse and fail in ways that the one in a box does not; this is how
OpenXR lets a test bring them about without touching what is tested.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from itertools import count
from typing import Any

import xr

_numbers = count(1)
_layers: list[Interceptor] = []
"""All that were made: the loader holds addresses of their functions, and no reference."""


class Interceptor(xr.DynamicApiLayerBase):
    """A layer to be named in `OpenXrSettings.api_layers`.

    Parameters
    ----------
    calls
        Name of an OpenXR function → what is called in its place, with the next layer's function
        first and then its own arguments; returns an `xr.Result`.
    """

    def __init__(self, **calls: Callable[..., Any]) -> None:
        super().__init__(f"XR_APILAYER_VRCOMFORT_test_{next(_numbers)}")
        self._calls = calls
        self._kept: list[Any] = []
        self._get = xr.PFN_xrGetInstanceProcAddr(self._find)
        self._create = xr.PFN_xrCreateApiLayerInstance(self._create_instance)
        _layers.append(self)

    def negotiate_loader_api_layer_interface(
        self,
        loader_info: Any,  # noqa: ARG002 - OpenXR calls it so
        layer_name: str,  # noqa: ARG002
        api_layer_request: Any,
    ) -> xr.Result:
        api_layer_request.layer_interface_version = xr.CURRENT_LOADER_API_LAYER_VERSION
        api_layer_request.layer_api_version = xr.XR_CURRENT_API_VERSION
        api_layer_request.get_instance_proc_addr = self._get
        api_layer_request.create_api_layer_instance = self._create
        return xr.Result.SUCCESS

    def _create_instance(self, info: Any, layer_info: Any, instance: Any) -> int:
        mine = layer_info.contents.next_info.contents
        # By its address: the loader's structure, which holds the pointer, does not last.
        self._next_get = xr.PFN_xrGetInstanceProcAddr(
            ctypes.cast(mine.next_get_instance_proc_addr, ctypes.c_void_p).value
        )
        create, layer_info.contents.next_info = mine.next_create_api_layer_instance, mine.next
        return create(info, layer_info, instance)

    def _find(self, instance: Any, name: bytes, function: Any) -> int:
        result = self._next_get(instance, name, function)
        called = name.decode()
        if called not in {*self._calls, "xrDestroyInstance"} or result != xr.Result.SUCCESS.value:
            return result
        kind = getattr(xr, f"PFN_{called}")
        following = kind(ctypes.cast(function.contents, ctypes.c_void_p).value)

        def call(*arguments: Any) -> int:
            own = self._calls.get(called)
            answer = own(following, *arguments) if own else following(*arguments)
            if called == "xrDestroyInstance":
                self._calls.clear()  # and what a test has left in them
            return int(getattr(answer, "value", answer))

        entry = kind(call)
        self._kept += [following, entry]
        ctypes.memmove(function, ctypes.byref(entry), ctypes.sizeof(entry))
        return result


def answer(result: xr.Result) -> Callable[..., xr.Result]:
    """Return a call that never reaches the runtime."""
    return lambda *_: result
