#!/usr/bin/env bash
# "Runtime in a box": prints the root folder of a system that has Monado 25 or newer with its null
# compositor: / where it is installed, otherwise a Debian 13 folder (see scripts/debian.sh).
# scripts/in_runtime.sh runs commands there.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/debian.sh"

packages=(
    monado-service libopenxr1-monado libopenxr-loader1 mesa-vulkan-drivers
    libgl1-mesa-dri libegl-mesa0 libegl1 libgl1 libglx-mesa0 xvfb
    python3 python3-venv ca-certificates
)

installed_version() {
    command -v monado-service >/dev/null || return 1
    dpkg-query -W -f='${Version}' monado-service 2>/dev/null ||
        rpm -q --queryformat '%{VERSION}' monado 2>/dev/null ||
        { pacman -Q monado 2>/dev/null | cut -d' ' -f2; }
}

version=$(installed_version) || version=
if [ "${version%%[!0-9]*}" != "" ] && [ "${version%%[!0-9]*}" -ge 25 ]; then
    echo /
    exit
fi

require_root "a folder with Monado" \
    "Install Monado 25 or newer yourself (Debian 13, Ubuntu 25.04: ${packages[*]:0:4})."
debian monado trixie "${packages[@]}"
echo "$system"
