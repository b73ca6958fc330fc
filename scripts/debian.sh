# Sourced by scripts/runtime.sh, scripts/in_runtime.sh and scripts/bare.sh: Debian systems in folders,
# made once and kept in ${VRCOMFORT_CACHE:-~/.cache/vrcomfort}. Needs root or sudo. Progress goes to
# standard error. What runs as root gets the functions of this file (`isolated`).
# shellcheck shell=bash

# shellcheck source=scripts/apt.sh
source "$(dirname "${BASH_SOURCE[0]}")/apt.sh"

PATH=$PATH:/usr/sbin:/sbin # debootstrap and chroot, which users do not look for
cache=${VRCOMFORT_CACHE:-$HOME/.cache/vrcomfort}
as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo --preserve-env)

say() { echo "$*" >&2; }

fail() { # fail WHAT REMEDY
    say "error: $1"
    say "       $2"
    exit 2
}

require_root() { # require_root PURPOSE REMEDY
    [ ${#as_root[@]} -eq 0 ] || command -v sudo >/dev/null || fail "$1 needs root." "$2"
}

require_debootstrap() {
    command -v debootstrap >/dev/null && return
    { apt_get update -qq && apt_get install -y -qq debootstrap; } || fail "debootstrap is missing and cannot be installed from here." \
        "Install debootstrap, then run the same command again."
}

# Mounts and processes of a command end with it, and with this script: they live in namespaces of
# their own, whose first process is killed when its parent dies.
isolated() { # isolated FUNCTION ARGUMENTS...: runs as root
    "${as_root[@]}" setpriv --pdeathsig KILL \
        unshare --mount --pid --fork --kill-child --propagation private \
        bash -euo pipefail -c "$(declare -f); \"\$@\"" bash "$@"
}

short_hash() { sha256sum | cut -c 1-12; }

# A folder is named after what it was made of, so one that is there is complete and stays as it is.
# FUNCTION makes PARTIAL, which becomes FOLDER; a second run waits, then finds the folder.
make_once() { # make_once FOLDER DESCRIPTION FUNCTION ARGUMENTS...: FUNCTION PARTIAL ARGUMENTS...
    local folder=$1 description=$2 function=$3 lock
    shift 3
    mkdir -p "$cache"
    touch "$folder.lock"
    [ ! -d "$folder" ] || return 0
    exec {lock}<"$folder.lock"
    flock "$lock"
    if [ ! -d "$folder" ]; then
        remove_unused
        say "Making $description (once) ..."
        "${as_root[@]}" rm -rf --one-file-system "$folder.partial"
        isolated "$function" "$folder.partial" "$@" >"$folder.log" 2>&1 || {
            tail -n 5 "$folder.log" >&2
            fail "$description could not be made." "All that was printed is in $folder.log."
        }
        "${as_root[@]}" mv "$folder.partial" "$folder"
    fi
    exec {lock}<&-
}

# Removes what nobody has used for a week; what is being used is locked (`in_use`).
remove_unused() {
    local lock folder
    find "$cache" -maxdepth 1 -name '*.lock' -mtime +7 | while read -r lock; do
        folder=${lock%.lock}
        flock --nonblock --no-fork "$lock" "${as_root[@]}" \
            rm -rf --one-file-system "$folder" "$folder.partial" "$folder.log" "$lock" || true
    done
}

# Sets `system` to the folder of a minimal Debian with some packages, which is made if need be.
debian() { # debian NAME SUITE PACKAGES...
    local name=$1 suite=$2
    shift 2
    system=$cache/$name-$({ echo "$suite" "$@" && declare -f make_debian; } | short_hash)
    [ -d "$system" ] || require_debootstrap
    make_once "$system" "a Debian $suite in $system" make_debian "$suite" "$(debian_mirror)" "$@"
}

make_debian() { # make_debian FOLDER SUITE MIRROR PACKAGES...
    local folder=$1 suite=$2 mirror=$3
    shift 3
    debootstrap --variant=minbase "$suite" "$folder" "$mirror"
    copy_network_settings "$folder"
    mount_devices "$folder"
    printf '#!/bin/sh\nexit 101\n' >"$folder/usr/sbin/policy-rc.d" # no daemons in the folder
    chmod +x "$folder/usr/sbin/policy-rc.d"
    chroot "$folder" apt-get -o Acquire::Retries=5 update
    DEBIAN_FRONTEND=noninteractive chroot "$folder" apt-get -o Acquire::Retries=5 \
        install -y --no-install-recommends "$@"
    copy_network_settings "$folder" # installing ca-certificates wrote its own bundle
    chroot "$folder" apt-get clean
}

# The mirror that this system uses, if it is a Debian.
debian_mirror() {
    [ -z "${DEBIAN_MIRROR:-}" ] || { echo "$DEBIAN_MIRROR"; return; }
    local used
    used=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' \
        2>/dev/null | head -n 1) || true
    echo "${used:-http://deb.debian.org/debian}"
}

mount_devices() { # mount_devices ROOT
    mount --rbind /dev "$1/dev"
    mount --rbind /sys "$1/sys"
    mount -t proc proc "$1/proc"
    mount -t tmpfs tmpfs "$1/run"
}

in_use() { # in_use FOLDER: until the program ends
    exec 8<"$1.lock"
    flock --shared 8
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
copy_network_settings() { # copy_network_settings ROOT
    local root=$1 bundle file
    mkdir -p "$root/root/.config/pip"
    apt-config dump 2>/dev/null | grep '^Acquire::' | grep -v -e IndexTargets -e Proxy-Auto \
        >"$root/etc/apt/apt.conf.d/90host" || true
    # Without what names files of this system: local wheels, certificates (set when running).
    for file in /etc/pip.conf "${PIP_CONFIG_FILE:-$HOME/.config/pip/pip.conf}"; do
        [ ! -s "$file" ] || sed -e '/file:/d' -e '/= *\//d' "$file" >"$root$(pip_place "$file")"
    done
    cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
    if bundle=$(host_certificates); then
        mkdir -p "$root/etc/ssl/certs"
        cp -L "$bundle" "$root/etc/ssl/certs/ca-certificates.crt"
    fi
}

# The variables that belong to those settings.
network_variables() { # prints NAME=VALUE lines
    local name bundle=/etc/ssl/certs/ca-certificates.crt
    printf '%s\n' SSL_CERT_FILE=$bundle PIP_CERT=$bundle REQUESTS_CA_BUNDLE=$bundle
    for name in $(compgen -e); do
        case $name in
            PIP_CERT | PIP_CONFIG_FILE) ;;
            PIP_* | *_proxy | *_PROXY)
                case ${!name} in /* | *file:*) ;; *) echo "$name=${!name}" ;; esac ;;
        esac
    done
}
