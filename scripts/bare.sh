#!/usr/bin/env bash
# scripts/bare.sh SUITE COMMAND...: runs COMMAND as a newcomer does, in a clean clone of the last
# commit on a fresh Debian (bookworm is 12, trixie is 13) that has make and git and little else.
# The clone's own scripts/setup.sh installs what it needs there. What it has installed is kept for
# the next run until it, pyproject.toml or requirements.lock changes; all else ends with the command.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/debian.sh"

case ${1:-} in
    bookworm | trixie) [ $# -gt 1 ] ;;
    *) false ;;
esac || fail "usage: scripts/bare.sh bookworm|trixie COMMAND..." \
    "For example: scripts/bare.sh bookworm make test"
suite=$1
shift
checkout=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

clone_in() { echo "$1/root/vrcomfort"; } # clone_in ROOT: always the same, as .venv names its place

in_clone() { # in_clone ROOT VARIABLES COMMAND...
    local root=$1 variables
    mapfile -t variables <<<"$2"
    shift 2
    chroot "$root" /usr/bin/env -i HOME=/root CI=true "${variables[@]}" \
        PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
        sh -c 'cd "$0" && exec "$@"' "$(clone_in "")" "$@"
}

# Root's own copy: git reads no repository of another user.
copy_clone() { cp -R --preserve=mode,timestamps "$1/." "$(clone_in "$2")"; } # copy_clone CLONE ROOT

make_prepared() { # make_prepared FOLDER PRISTINE CLONE VARIABLES
    local folder=$1 pristine=$2 clone=$3 variables=$4
    in_use "$pristine"
    cp -a --reflink=auto "$pristine" "$folder"
    mkdir "$(clone_in "$folder")"
    copy_clone "$clone" "$folder"
    copy_network_settings "$folder"
    mount_devices "$folder"
    in_clone "$folder" "$variables" scripts/setup.sh --tests
    rm -rf "$folder/root/.cache"
    find "$(clone_in "$folder")" -mindepth 1 -maxdepth 1 ! -name .venv -exec rm -rf {} +
}

enter() { # enter PREPARED RUN VARIABLES COMMAND...
    local prepared=$1 run=$2 variables=$3
    shift 3
    in_use "$prepared"
    mkdir "$run/changes" "$run/work" "$run/root"
    # Not every file system can hold the changes of an overlay.
    mount -t overlay overlay "$run/root" 2>/dev/null \
        -o "lowerdir=$prepared,upperdir=$run/changes,workdir=$run/work" ||
        cp -a --reflink=auto "$prepared/." "$run/root"
    copy_clone "$run/clone" "$run/root"
    copy_network_settings "$run/root"
    mount_devices "$run/root"
    in_clone "$run/root" "$variables" "$@"
}

require_root "a fresh Debian in a folder" "Run this as root, or install sudo."
debian "$suite" "$suite" make git ca-certificates
run=$(mktemp -d "$cache/run-XXXXXX")
trap '"${as_root[@]}" rm -rf --one-file-system "$run" "$run.lock"' EXIT
touch "$run.lock"
in_use "$run"

[ -z "$(git -C "$checkout" status --porcelain)" ] ||
    say "note: $checkout has changes that are not committed; they are not in the clone."
git clone --quiet --depth 1 "file://$checkout" "$run/clone"
key=$(cd "$run/clone" && cat scripts/setup.sh pyproject.toml requirements.lock &&
    declare -f make_prepared in_clone)
prepared=$system-$(short_hash <<<"$key")
variables=$(network_variables)
make_once "$prepared" "what scripts/setup.sh installs on Debian $suite" \
    make_prepared "$system" "$run/clone" "$variables"
isolated enter "$prepared" "$run" "$variables" "$@"
