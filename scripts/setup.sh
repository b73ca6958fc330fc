#!/usr/bin/env bash
# Makes .venv with everything that `make demo` and `make test` need; run again, it does nothing new.
# On Debian and Ubuntu it installs missing system packages (root or sudo); elsewhere it names them.
set -euo pipefail
cd "$(dirname "$0")/.."

system_packages=(python3-venv libegl1 libgl1 libegl-mesa0 libgl1-mesa-dri)

install_system_packages() {
    local as_root=()
    # shellcheck source=scripts/apt.sh
    source scripts/apt.sh
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || return 1
        as_root=(sudo)
    fi
    command -v apt-get >/dev/null || return 1
    echo "Installing: $*"
    apt_get update -qq && apt_get install -y -qq --no-install-recommends "$@"
}

require() { # require WHAT PACKAGES...
    local what=$1
    shift
    install_system_packages "$@" && return
    echo "error: $what is missing and cannot be installed from here." >&2
    echo "       Install these packages (Debian/Ubuntu names), then run the same command again:" >&2
    echo "       $*" >&2
    exit 2
}

find_python() {
    local candidate
    for candidate in ${PYTHON:-} python3.13 python3.12 python3.11 python3; do
        if command -v "$candidate" >/dev/null &&
            "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            command -v "$candidate"
            return
        fi
    done
    return 1
}

python=$(find_python) || require "Python 3.11 or newer" python3 python3-venv
python=${python:-$(find_python)} || {
    echo "error: this system's python3 is older than 3.11; set PYTHON=/path/to/python3.11" >&2
    exit 2
}

"$python" -c 'import ensurepip, venv' 2>/dev/null || require "Python's venv module" python3-venv

# A venv that an interrupted run left half-made is made again.
.venv/bin/python -c 'import pip' 2>/dev/null || "$python" -m venv --clear .venv

# The stamp holds what was installed, so an edited pyproject or lock installs again.
wanted=$(cat scripts/setup.sh pyproject.toml requirements.lock | sha256sum)
if [ "$(cat .venv/installed 2>/dev/null)" != "$wanted" ]; then
    echo "Installing the Python packages into .venv (about 1.4 GB, for development) ..."
    # Nothing but what requirements.lock has, each file compared with its hash; then the project.
    pip=(.venv/bin/python -m pip install --quiet --disable-pip-version-check --retries 10)
    "${pip[@]}" --require-hashes --requirement requirements.lock
    "${pip[@]}" --no-index --no-deps --no-build-isolation --editable .
    echo "$wanted" >.venv/installed
fi

can_draw() {
    .venv/bin/python -c 'from vrcomfort.gpu.gl import create_context; create_context()' 2>/dev/null
}
can_draw || require "an OpenGL driver with EGL" "${system_packages[@]}"
can_draw || {
    echo "error: EGL is installed but gives no OpenGL context that is new enough; it says:" >&2
    .venv/bin/python -c 'from vrcomfort.gpu.gl import create_context; create_context()' 2>&1 |
        tail -n 1 >&2 || true
    exit 2
}

# Tests of windows need a screen, here one without a monitor; those of a report's R script need R;
# those of headsets a runtime that is built for them.
has() { command -v "$1" >/dev/null || [ -e "$1" ]; }
if [ "${1:-}" = --tests ]; then
    for needed in Xvfb xdotool Rscript cc /usr/include/openxr/openxr.h; do
        has "$needed" || require "$needed (for the tests)" \
            xvfb xdotool libglx-mesa0 r-base-core gcc libc6-dev libopenxr-dev
    done
fi

# Tests of pages need a browser; CI has one, elsewhere they are skipped without it.
if [ "${2:-}" = --browser ]; then
    scripts/browser.sh >/dev/null || [ -z "${CI:-}" ] || exit 2
fi
