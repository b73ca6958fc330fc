#!/usr/bin/env bash
# scripts/windows.sh COMMAND...: runs COMMAND (python, or pytest) with a Win32 CPython under Wine, in
# this checkout: the Windows wheels of requirements.lock, OpenGL by Mesa, an OpenXR runtime of ours
# (tests/openxr_runtime) as a DLL, and no debug C runtime. docs/windows.md says what that is worth.
# All of it is made once, and kept in a Debian 13 folder and one beside it (see scripts/debian.sh).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/debian.sh"
checkout=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

[ $# -gt 0 ] || fail "usage: scripts/windows.sh COMMAND..." \
    "For example: scripts/windows.sh pytest -m windows"

packages=(
    wine wine64 gcc-mingw-w64-x86-64-win32 libopenxr-dev xvfb libgl1 libglx-mesa0 libgl1-mesa-dri
    python3 python3-venv libpython3.13-stdlib ca-certificates
)
# Brings a Win32 CPython without an installer; uv installs another system's wheels.
tools="uv==0.13.9
panda3d==1.10.16 --hash=sha256:0e505261bb58d8402d0099c291f1a3459acfdd38f3e7d666e72aa2e1ea5dc46f"
# What Wine's C runtime has as names alone (tests/windows_testbed/complex_math.c).
complex="cabs cacos cacosh carg casin casinh catan catanh ccos ccosh cexp cimag clog conj cpow cproj
creal csin csinh csqrt ctan ctanh"

exports_of() { x86_64-w64-mingw32-objdump -p "$1" | awk '/\+base\[/ && !/RVA/ {print $NF}'; }

mingw() { x86_64-w64-mingw32-gcc -std=gnu11 -O1 -static-libgcc -Wall -Wextra -Werror "$@"; }

get_python() { # get_python WIN32 TOOLS: its DLLs, and the standard library of the same minor version
    local win32=$1 tools=$2 wheels=$1/wheels
    python3 -m venv "$win32/tools"
    "$win32/tools/bin/pip" install --quiet --only-binary :all: "${tools%%$'\n'*}"
    "$win32/tools/bin/pip" download --quiet --no-deps --only-binary :all: --platform win_amd64 \
        --python-version 3.13 --require-hashes --requirement <(echo "${tools#*$'\n'}") --dest "$wheels"
    python3 -m zipfile -e "$wheels"/panda3d-*.whl "$wheels"
    rm "$wheels"/deploy_libs/{api-ms-*,VCRUNTIME*,*313t*} # Wine has its own C runtime
    mkdir "$win32/DLLs"
    mv "$wheels"/deploy_libs/*.{pyd,dll} "$win32/DLLs"
    mv "$win32/DLLs/python313.dll" "$win32"
    cp -r /usr/lib/python3.13 "$win32/Lib"
    rm -rf "$wheels" "$win32"/Lib/{lib-dynload,EXTERNALLY-MANAGED,dist-packages}
}

get_wheels() { # get_wheels WIN32 LOCK
    "$1/tools/bin/uv" pip install --quiet --no-cache --only-binary :all: --require-hashes \
        --python-platform x86_64-pc-windows-msvc --python-version 3.13 \
        --target "$1/Lib/site-packages" --requirement "$2"
    rm -rf "$1/tools"
    python3 -m compileall -q -j 2 "$1/Lib" || true # some packages have files of later syntax
}

make_libraries() { # make_libraries WIN32 SOURCES COMPLEX: what the wheel of Python and Wine lack
    local win32=$1 sources=$2 complex=$3 name own
    own="($(xargs <<<"$complex" | tr ' ' '|'))[fl]?"
    mingw -municode -o "$win32/python.exe" "$sources/python.c" "$win32/python313.dll"
    { echo EXPORTS && exports_of "$win32/python313.dll" | sed 's/.*/& = python313.&/'; } \
        >"$win32/python3.def"
    mingw -shared -nostdlib -Wl,--entry=0 -o "$win32/python3.dll" "$win32/python3.def"
    {
        echo EXPORTS
        for name in $complex; do
            printf '%s = own_%s\n' "$name" "$name" "${name}f" "${name}f" "${name}l" "$name"
        done
        exports_of /usr/lib/x86_64-linux-gnu/wine/x86_64-windows/ucrtbase.dll |
            grep -vxE "$own" | sed 's/.*/& = ucrtbase.&/'
    } >"$win32/math.def"
    mingw -shared -o "$win32/vrcomfort-math-l1-1-0-shim.dll" "$sources/complex_math.c" \
        "$win32/math.def"
    grep -rlaPZ "\\x00$own\\x00" --include='*.pyd' --include='*.dll' "$win32/Lib/site-packages" |
        xargs -0 sed -i 's/api-ms-win-crt-math-l1-1-0\.dll/vrcomfort-math-l1-1-0-shim.dll/g'
}

make_prefix() { # make_prefix WIN32: the files of a new Windows
    export WINEPREFIX=$1/prefix WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml="
    wineboot --init # not with a TMPDIR: it would crash
    wineserver --wait
}

make_win32() { # make_win32 FOLDER ROOT CHECKOUT VARIABLES TOOLS COMPLEX: as root in new namespaces
    local folder=$1 root=$2 checkout=$3 variables=$4
    shift 4
    mapfile -t variables <<<"$variables"
    in_use "$root"
    mkdir "$folder"
    mount_devices "$root"
    mkdir -p "$root/opt/win32" "$root/mnt/checkout"
    mount --bind "$folder" "$root/opt/win32"
    mount --bind -o ro "$checkout" "$root/mnt/checkout"
    chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin \
        "${variables[@]}" bash -euo pipefail -c "$(declare -f \
            exports_of mingw get_python get_wheels make_libraries make_prefix)
            win32=/opt/win32 checkout=/mnt/checkout
            get_python \$win32 \"\$1\"
            get_wheels \$win32 \$checkout/requirements.lock
            make_libraries \$win32 \$checkout/tests/windows_testbed \"\$2\"
            make_prefix \$win32" make_win32 "$@"
}

make_runtime() { # make_runtime CHECKOUT FOLDER: the OpenXR runtime of the tests, the active one
    local folder=$2
    mkdir "$folder/include"
    ln -s /usr/include/openxr "$folder/include" # without those of Linux beside it
    mingw -shared -I"$folder/include" -o "$folder/openxr_runtime.dll" \
        "$1"/tests/openxr_runtime/*.c -lopengl32 -lgdi32
    echo '{"file_format_version": "1.0.0", "runtime": {"library_path": "Z:\\opt\\run\\openxr_runtime.dll"}}' \
        >"$folder/runtime.json"
    # The loader takes no variable's word in a program of an administrator.
    wine reg add 'HKLM\SOFTWARE\Khronos\OpenXR\1' /v ActiveRuntime /f \
        /d "$(windows_path "$folder/runtime.json")" >/dev/null 2>&1
}

windows_path() { echo "Z:${1//\//\\}"; }

inside() { # inside CHECKOUT FOLDER COMMAND...
    local checkout=$1 folder=$2 program=$3 run=/opt/run status=0
    shift 3
    export HOME=/root LANG=C.UTF-8 WINEPREFIX=/opt/win32/prefix WINEDEBUG=-all
    export WINEDLLOVERRIDES="mscoree,mshtml,winedbg.exe=" # a crash ends the program
    VRCOMFORT_TEST_RUNTIME=$(windows_path "$run/openxr_runtime.dll")
    PYTHONPATH=$(windows_path "$checkout")
    PYTHONPYCACHEPREFIX=$(windows_path "$run/compiled")
    export VRCOMFORT_TEST_RUNTIME PYTHONPATH PYTHONPYCACHEPREFIX PYTHONUTF8=1
    mkfifo "$run/display"
    Xvfb -displayfd 3 -screen 0 1280x1024x24 -nolisten tcp 3>"$run/display" 2>/dev/null &
    DISPLAY=:$(head -n 1 "$run/display")
    export DISPLAY # for Wine's first program, too: what starts without one makes no windows
    make_runtime "$checkout" "$run"
    cd "$folder"
    [ "$program" = python ] || set -- -m "$program" "$@"
    wine /opt/win32/python.exe "$@" 2> >(grep -v -e 'wine32 is missing' -e '^multiarch needs' \
        -e '^execute "dpkg' -e XDG_RUNTIME_DIR >&2) || status=$?
    wineserver --kill || true
    return "$status"
}

enter() { # enter ROOT WIN32 RUN CHECKOUT FOLDER COMMAND...: as root in the new namespaces
    local root=$1 win32=$2 run=$3 checkout=$4 folder=$5 place
    shift 3
    in_use "$root"
    exec 9<"$win32.lock"
    flock --shared 9
    mount_devices "$root"
    mkdir -p "$root/opt/win32" "$root/opt/run" "$run/changes" "$run/work" "$run/opt"
    mount -t overlay overlay "$root/opt/win32" 2>/dev/null \
        -o "lowerdir=$win32,upperdir=$run/changes,workdir=$run/work" ||
        { cp -a --reflink=auto "$win32/." "$run/changes" &&
            mount --bind "$run/changes" "$root/opt/win32"; }
    mount --bind "$run/opt" "$root/opt/run"
    for place in /tmp "$checkout" "$folder"; do
        mkdir -p "$root$place"
        mountpoint -q "$root$place" || mount --bind "$place" "$root$place"
    done
    chroot "$root" /bin/bash -euo pipefail -c \
        "$(declare -f mingw make_runtime windows_path inside); inside \"\$@\"" inside "$@"
}

require_root "a Debian with Wine in a folder" "Run this as root, or install sudo."
debian windows trixie "${packages[@]}"
key=$(cat "$checkout"/requirements.lock "$checkout"/tests/windows_testbed/*.c && echo "$tools" &&
    declare -f get_python get_wheels make_libraries make_prefix)
win32=$system-win32-$(short_hash <<<"$key")
make_once "$win32" "a Win32 Python with the wheels of requirements.lock" \
    make_win32 "$system" "$checkout" "$(network_variables)" "$tools" "$complex"
run=$(mktemp -d "$cache/run-XXXXXX")
trap '"${as_root[@]}" rm -rf --one-file-system "$run" "$run.lock"' EXIT
touch "$run.lock"
in_use "$run"
isolated enter "$system" "$win32" "$run" "$checkout" "$PWD" "$@"
