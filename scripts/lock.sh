#!/usr/bin/env bash
# scripts/lock.sh [--upgrade | --upgrade-package NAME]: writes requirements.lock from pyproject.toml:
# what vrcomfort needs with all extras and tools, each in one version, for every Python and system,
# with the hashes of its files. Versions stay as they are unless asked for. Needs uv.
set -euo pipefail
cd "$(dirname "$0")/.."

command -v uv >/dev/null || {
    echo "error: uv is missing; install it in an environment of its own: pip install uv" >&2
    exit 2
}

partial=$(mktemp)
trap 'rm -f "$partial"' EXIT
cp requirements.lock "$partial" # whose versions uv keeps
uv pip compile --quiet --universal --python-version 3.11 --all-extras --no-build \
    --generate-hashes --no-annotate --no-header --no-emit-index-url \
    "$@" --output-file "$partial" pyproject.toml

# Here nothing has to be compiled. On Linux on ARM glcontext and miniaudio are.
for system in x86_64-manylinux_2_28 x86_64-pc-windows-msvc; do
    for version in 3.11 3.12 3.13 3.14; do
        uv pip install --quiet --dry-run --python-platform $system --python-version $version \
            --only-binary :all: --require-hashes --target "$partial.target" \
            --requirement "$partial" || {
            echo "error: not installable from wheels on Python $version, $system" >&2
            exit 1
        }
    done
done

{
    echo "# Made by scripts/lock.sh from pyproject.toml, for Python 3.11 to 3.14 on Linux and Windows."
    cat "$partial"
} >requirements.lock
