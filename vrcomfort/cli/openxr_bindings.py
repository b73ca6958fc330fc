"""Whether OpenXR can be spoken at all."""

from __future__ import annotations

import sys
from importlib.metadata import PackageNotFoundError, version

from vrcomfort.errors import InputError, pip_install

REQUIREMENT = "pyopenxr>=1.1.5301,<1.1.6302"
"""As in pyproject.toml: from 1.1.6302 on, the Windows libraries need a debug C runtime."""
_DEBUG_SINCE = (1, 1, 6302)
_REDISTRIBUTABLE = "https://aka.ms/vs/17/release/vc_redist.x64.exe"


def require_bindings() -> str:
    """Return the version of pyopenxr.

    Raises
    ------
    InputError
        If it, or the OpenXR loader that it brings, is missing.
    """
    try:
        from xr.version import PYOPENXR_VERSION
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] == "xr":
            raise InputError(
                f"the OpenXR bindings are not installed; {pip_install(REQUIREMENT)}"
            ) from error
        raise _not_loaded(error) from error
    except (ImportError, AttributeError) as error:  # as PyOpenGL says that a library is missing
        raise _not_loaded(error) from error
    except OSError as error:
        message = f"a library of the OpenXR bindings cannot be loaded ({error})"
        raise InputError(f"{message}; {_library_remedy()}") from error
    return str(PYOPENXR_VERSION)


def _library_remedy() -> str:
    if sys.platform == "win32":
        if (installed := _installed_version()) >= _DEBUG_SINCE:
            release = ".".join(map(str, installed))
            needs = f"pyopenxr {release} needs a debug C runtime on Windows"
            return f"{needs}; install another version: {pip_install(REQUIREMENT)}"
        return f"install the Microsoft Visual C++ Redistributable: {_REDISTRIBUTABLE}"
    return f"reinstall the bindings that bring it: {pip_install(REQUIREMENT, again=True)}"


def _installed_version() -> tuple[int, ...]:
    try:
        release = version("pyopenxr")
    except PackageNotFoundError:
        return ()
    return tuple(int(part) for part in release.split(".") if part.isdecimal())


def _not_loaded(error: Exception) -> InputError:
    return InputError(
        f"the OpenXR bindings cannot be loaded ({error}); install the graphics libraries (on "
        "Debian or Ubuntu 'apt-get install libgl1 libegl1', elsewhere your graphics driver) and "
        f"the bindings: {pip_install(REQUIREMENT, 'PyOpenGL', again=True)}"
    )
