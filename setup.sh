#!/bin/sh
# Make .venv with cbdsl and an extra, and compile in advance:  ./setup.sh sim|dev|...
# As root on Debian, apt-get installs the packages that pip cannot provide; otherwise they are named.
set -eu
cd "$(dirname "$0")"
extra="${1:-sim}"

fail() { echo "setup: $1" >&2; exit 1; }
has_library() { ldconfig -p 2>/dev/null | grep -q "$1"; }
is_supported() {
    "$1" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null
}

# The Python that is asked for, else the first that is supported.
python=""
set -- python3 python3.14 python3.13 python3.12 python3.11
if [ -n "${PYTHON:-}" ]; then set -- "$PYTHON"; fi
for candidate; do
    if is_supported "$candidate"; then python="$candidate"; break; fi
done
[ -n "$python" ] || fail "no supported Python in '${PYTHON:-PATH}': install 3.11 to 3.14, or name one: PYTHON=/path/to/python $0 $extra"

needed=""
faster=""
"$python" -c 'import ensurepip, venv' 2>/dev/null || needed="python3-venv"
if command -v ldconfig >/dev/null 2>&1; then
    { has_library libEGL.so.1 && has_library libGL.so.1; } || faster="libegl1 libgl1 libgl1-mesa-dri"
fi
if [ -n "$needed$faster" ]; then
    if command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ]; then
        echo "setup: apt-get install $needed $faster"
        # shellcheck disable=SC2086 -- one word per package
        { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $needed $faster; } >/dev/null 2>&1 ||
            echo "setup: apt-get could not install $needed $faster; continuing without" >&2
    elif [ -n "$faster" ]; then
        echo "setup: images are rendered faster with $faster (names in Debian)" >&2
    fi
fi
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
    fail "$python cannot make virtual environments: install its package python3-venv"

"$python" -m venv .venv
.venv/bin/python -m pip install --quiet --disable-pip-version-check -e ".[$extra]"
if .venv/bin/python -c 'import numba, pinocchio' 2>/dev/null; then
    # Whatever prevents it is printed, and costs nothing but time later.
    .venv/bin/cb warm || true
fi
echo "setup: ready; try .venv/bin/cb run reachtouch"
