#!/usr/bin/env bash
# scripts/in_runtime.sh COMMAND...: runs COMMAND where Monado 25 is (see scripts/runtime.sh).
# Monado's client library must come from the same system as its service, so the command itself
# runs in the folder too: same checkout, same working directory, same /tmp, and a venv made there.
# Mounts and stray processes end with the command (see scripts/debian.sh).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
source "$here/debian.sh"
checkout=$(dirname "$here")
root=$("$here/runtime.sh")

if [ "$root" = / ]; then
    "$here/setup.sh"
    VRCOMFORT_RUNTIME=1 PATH=$checkout/.venv/bin:$PATH exec "$@"
fi

# Commands share the lock while they run; who installs other packages has it alone.
prepare_venv() { # inside: the packages of this checkout's lock; the checkout itself stays outside
    local venv=$1 checkout=$2 wanted
    wanted=$(sha256sum <"$checkout/requirements.lock")
    exec 9>"$venv.lock"
    take_lock --shared
    is_installed && return
    take_lock --exclusive
    is_installed || install_packages
    flock --shared 9
}

take_lock() {
    flock --nonblock "$1" 9 && return
    echo "Waiting for another run beside Monado, which needs or installs other packages ..." >&2
    flock "$1" 9
}

is_installed() { [ "$(cat "$venv/installed" 2>/dev/null)" = "$wanted" ]; }

install_packages() {
    "$venv/bin/python" -c 'import pip' 2>/dev/null || python3 -m venv --clear "$venv"
    echo "Installing the Python packages next to Monado ..." >&2
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --retries 10 \
        --require-hashes --requirement "$checkout/requirements.lock" >&2
    printf '#!%s/bin/python\nfrom vrcomfort.cli import main\nmain()\n' "$venv" \
        >"$venv/bin/vrcomfort"
    chmod +x "$venv/bin/vrcomfort"
    echo "$wanted" >"$venv/installed"
}

inside() { # inside VENV CHECKOUT FOLDER COMMAND...
    local venv=$1 checkout=$2 folder=$3
    shift 3
    export VRCOMFORT_RUNTIME=1 HOME=/root LANG=C.UTF-8 PYTHONPATH=$checkout PATH=$venv/bin:/usr/sbin:/usr/bin
    local bundle=/etc/ssl/certs/ca-certificates.crt
    export SSL_CERT_FILE=$bundle PIP_CERT=$bundle REQUESTS_CA_BUNDLE=$bundle
    unset PIP_CONFIG_FILE PIP_FIND_LINKS PIP_EXTRA_INDEX_URL PYTHONHOME VIRTUAL_ENV XDG_RUNTIME_DIR XDG_CONFIG_HOME
    prepare_venv "$venv" "$checkout"
    cd "$folder"
    "$@"
}

enter() { # enter ROOT CHECKOUT FOLDER COMMAND...: as root in the new namespaces
    local root=$1 checkout=$2 folder=$3 place
    shift
    in_use "$root"
    mount_devices "$root"
    for place in /tmp "$checkout" "$folder"; do
        mkdir -p "$root$place"
        mountpoint -q "$root$place" || mount --bind "$place" "$root$place"
    done
    chroot "$root" /bin/bash -euo pipefail -c \
        "$(declare -f prepare_venv take_lock is_installed install_packages inside); inside \"\$@\"" inside /opt/venv "$@"
}

isolated enter "$root" "$checkout" "$PWD" "$@"
