# Sourced: apt_get ARGUMENTS... is apt-get as root, after package installations that run now.
# `as_root` is () or (sudo), as the caller has it. Prints nothing but what went wrong.
# shellcheck shell=bash

apt_get() {
    local said='' output
    for _ in {1..120}; do
        output=$("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive LC_ALL=C \
            apt-get -o Acquire::Retries=5 -o DPkg::Lock::Timeout=600 "$@" 2>&1) && return 0
        case $output in
            *"Could not get lock"* | *"Unable to acquire the dpkg"*) ;; # lists have no timeout
            *) echo "$output" >&2 && return 1 ;;
        esac
        [ -n "$said" ] || echo "Waiting for another package installation to end ..." >&2
        said=yes
        sleep 5
    done
    echo "$output" >&2
    return 1
}
