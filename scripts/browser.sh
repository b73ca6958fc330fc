#!/usr/bin/env bash
# A browser without a screen, for the tests of pages: prints the path of a Chromium or Chrome that
# works headless. One that is there is used first ($CHROME, if set); on Debian and Ubuntu one is
# installed otherwise (root or sudo). `--find` installs nothing. Progress goes to standard error.
set -euo pipefail
# shellcheck source=scripts/apt.sh
source "$(dirname "${BASH_SOURCE[0]}")/apt.sh"

candidates=("${CHROME:-}" chromium chromium-browser google-chrome google-chrome-stable chrome)
folder=
trap '[ -z "$folder" ] || rm -rf "$folder"' EXIT

say() { echo "$*" >&2; }

fail() {
    say "error: $1"
    say "       $2"
    exit 2
}

works() { # works PATH: a page is read and its text comes back
    folder=$(mktemp -d)
    local status=1
    timeout 120 "$1" --headless --no-sandbox --disable-gpu --disable-dev-shm-usage \
        --user-data-dir="$folder" --dump-dom 'data:text/html,<p>works</p>' 2>/dev/null |
        grep '<p>works</p>' >/dev/null && status=0 # not -q: it would leave while all is written
    rm -rf "$folder"
    return "$status"
}

find_browser() {
    local candidate path
    for candidate in "${candidates[@]}"; do
        [ -n "$candidate" ] && path=$(command -v "$candidate") && works "$path" || continue
        echo "$path"
        return
    done
    return 1
}

install() { # install PACKAGES...
    local as_root=()
    command -v apt-get >/dev/null || return 1
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || return 1
        as_root=(sudo)
    fi
    say "Installing: $*"
    { apt_get update -qq && apt_get install -y -qq --no-install-recommends "$@"; } || return 1
}

# What steers a browser, for the tests of the console; they are skipped without it.
[ "${1:-}" = --find ] || command -v chromedriver >/dev/null ||
    install chromium chromium-driver || say "chromedriver is missing and cannot be installed here"
find_browser && exit
{ [ "${1:-}" != --find ] && install chromium chromium-driver; } || fail "there is no Chromium or Chrome here that works without a screen." \
    "Install one (Debian: chromium), or name it: CHROME=/path/to/chrome; then run this again."
find_browser || fail "Chromium is installed, but reads no page without a screen." \
    "Try: chromium --headless --no-sandbox --dump-dom 'data:text/html,works'"
