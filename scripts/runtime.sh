#!/usr/bin/env bash
# "Runtime in a box": prints the root folder of a system that has Monado 25 or newer with its null
# compositor: / where it is installed, otherwise a Debian 13 folder, made once and kept in
# ${VRCOMFORT_CACHE:-~/.cache/vrcomfort}/monado. Progress goes to standard error.
# scripts/in_runtime.sh runs commands there.
set -euo pipefail

suite=trixie
cache=${VRCOMFORT_CACHE:-$HOME/.cache/vrcomfort}
root=$cache/monado/$suite
packages=(
    monado-service libopenxr1-monado libopenxr-loader1 mesa-vulkan-drivers
    libgl1-mesa-dri libegl-mesa0 libegl1 libgl1 libglx-mesa0 xvfb
    python3 python3-venv ca-certificates
)
as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo)

say() { echo "$*" >&2; }

fail() {
    say "error: $1"
    say "       $2"
    exit 2
}

installed_version() {
    command -v monado-service >/dev/null || return 1
    dpkg-query -W -f='${Version}' monado-service 2>/dev/null ||
        rpm -q --queryformat '%{VERSION}' monado 2>/dev/null ||
        { pacman -Q monado 2>/dev/null | cut -d' ' -f2; }
}

# The mirror that this system uses, if it is a Debian.
debian_mirror() {
    [ -z "${DEBIAN_MIRROR:-}" ] || { echo "$DEBIAN_MIRROR"; return; }
    local used
    used=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' \
        2>/dev/null | head -n 1) || true
    echo "${used:-http://deb.debian.org/debian}"
}

host_certificates() {
    local bundle
    for bundle in "${SSL_CERT_FILE:-}" /etc/ssl/certs/ca-certificates.crt \
        /etc/pki/tls/certs/ca-bundle.crt /etc/ssl/ca-bundle.pem; do
        [ -s "$bundle" ] && { echo "$bundle"; return; }
    done
    return 1
}

pip_place() { [ "$1" = /etc/pip.conf ] && echo "$1" || echo /root/.config/pip/pip.conf; }

# How this system reaches the world: proxies and other download settings of apt, pip's
# configuration, certificate authorities, name servers.
copy_network_settings() { # copy_network_settings FOLDER
    local folder=$1 bundle file
    mkdir -p "$folder/root/.config/pip"
    apt-config dump 2>/dev/null | grep '^Acquire::' | grep -v -e IndexTargets -e Proxy-Auto \
        >"$folder/etc/apt/apt.conf.d/90host" || true
    # Without what names files of this system: local wheels, certificates (set when running).
    for file in /etc/pip.conf "${PIP_CONFIG_FILE:-$HOME/.config/pip/pip.conf}"; do
        [ ! -s "$file" ] || sed -e '/file:/d' -e '/= *\//d' "$file" >"$folder$(pip_place "$file")"
    done
    cp -L /etc/resolv.conf /etc/hosts "$folder/etc/"
    if bundle=$(host_certificates); then
        mkdir -p "$folder/etc/ssl/certs"
        cp -L "$bundle" "$folder/etc/ssl/certs/ca-certificates.crt"
    fi
}

# Everything as root, in its own mount namespace, so that no mount outlives it.
make_folder() { # make_folder FOLDER MIRROR
    local folder=$1 mirror=$2
    debootstrap --variant=minbase "$suite" "$folder" "$mirror" >"$folder.log" 2>&1
    copy_network_settings "$folder"
    mount --rbind /dev "$folder/dev"
    mount -t proc proc "$folder/proc"
    printf '#!/bin/sh\nexit 101\n' >"$folder/usr/sbin/policy-rc.d" # no daemons in the folder
    chmod +x "$folder/usr/sbin/policy-rc.d"
    chroot "$folder" apt-get -o Acquire::Retries=5 update >>"$folder.log" 2>&1
    DEBIAN_FRONTEND=noninteractive chroot "$folder" apt-get -o Acquire::Retries=5 \
        install -y --no-install-recommends "${packages[@]}" >>"$folder.log" 2>&1
    copy_network_settings "$folder" # installing ca-certificates wrote its own bundle
    chroot "$folder" apt-get clean
}

version=$(installed_version) || version=
if [ "${version%%[!0-9]*}" != "" ] && [ "${version%%[!0-9]*}" -ge 25 ]; then
    echo /
    exit
fi

mkdir -p "$cache/monado"
exec 9>"$cache/monado/lock"
flock 9 # two runs at once: the second waits, then finds the folder

if [ ! -e "$root/complete" ]; then
    [ ${#as_root[@]} -eq 0 ] || command -v sudo >/dev/null ||
        fail "making a folder with Monado needs root." \
            "Install Monado 25 or newer yourself (Debian 13, Ubuntu 25.04: ${packages[*]:0:4})."
    command -v debootstrap >/dev/null ||
        {
            "${as_root[@]}" apt-get -o Acquire::Retries=5 update -qq &&
                "${as_root[@]}" apt-get -o Acquire::Retries=5 install -y -qq debootstrap
        } >&2 ||
        fail "debootstrap is missing and cannot be installed from here." \
            "Install debootstrap, then run the same command again."
    say "Making a Debian 13 folder with Monado in $root (2 minutes, once) ..."
    "${as_root[@]}" rm -rf --one-file-system "$root" "$root.partial"
    "${as_root[@]}" env DEBIAN_MIRROR="${DEBIAN_MIRROR:-}" HOME="$HOME" \
        unshare --mount --propagation private bash -euo pipefail -c "
            $(declare -p suite packages)
            $(declare -f make_folder copy_network_settings pip_place host_certificates)
            make_folder \"\$@\"" make_folder "$root.partial" "$(debian_mirror)" ||
        fail "the folder could not be made." "The last lines of $root.partial.log say why."
    "${as_root[@]}" mv "$root.partial" "$root"
    "${as_root[@]}" touch "$root/complete"
fi
echo "$root"
