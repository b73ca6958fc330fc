"""Whether OpenXR can be spoken at all."""

from __future__ import annotations

from vrcomfort.errors import InputError


def require_bindings() -> str:
    """Return the version of pyopenxr.

    Raises
    ------
    InputError
        If it, or the OpenXR loader that it brings, is missing.
    """
    try:
        from xr.version import PYOPENXR_VERSION
    except ImportError as error:
        raise InputError(
            "the OpenXR bindings are not installed; pip install 'vrcomfort[openxr]'"
        ) from error
    except OSError as error:
        raise InputError(
            f"the OpenXR loader cannot be loaded ({error}); reinstall the bindings that bring it: "
            "pip install --force-reinstall pyopenxr"
        ) from error
    return str(PYOPENXR_VERSION)
