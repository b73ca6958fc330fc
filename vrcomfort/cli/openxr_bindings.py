"""Whether OpenXR can be spoken at all."""

from __future__ import annotations

from vrcomfort.errors import InputError, pip_install


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
                f"the OpenXR bindings are not installed; {pip_install('pyopenxr')}"
            ) from error
        raise _not_loaded(error) from error
    except (ImportError, AttributeError) as error:  # as PyOpenGL says that a library is missing
        raise _not_loaded(error) from error
    except OSError as error:
        raise InputError(
            f"the OpenXR loader cannot be loaded ({error}); reinstall the bindings that bring it: "
            f"{pip_install('pyopenxr', again=True)}"
        ) from error
    return str(PYOPENXR_VERSION)


def _not_loaded(error: Exception) -> InputError:
    return InputError(
        f"the OpenXR bindings cannot be loaded ({error}); install the graphics libraries (on "
        "Debian or Ubuntu 'apt-get install libgl1 libegl1', elsewhere your graphics driver) and "
        f"the bindings: {pip_install('pyopenxr', 'PyOpenGL', again=True)}"
    )
