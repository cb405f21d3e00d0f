#!/bin/sh
# Make .venv with cbdsl and one of its extras in it:  ./setup.sh sim|dev
# What pip cannot bring is installed with apt-get where this may be done, and named otherwise.
set -eu
cd "$(dirname "$0")"
extra="${1:-sim}"
python="${PYTHON:-python3}"

has_library() { ldconfig -p 2>/dev/null | grep -q "$1"; }

"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || {
    echo "setup: cbdsl needs Python 3.11 or newer; PYTHON=/path/to/python names another than $python" >&2
    exit 1
}

missing=""
"$python" -c 'import ensurepip, venv' 2>/dev/null || missing="$missing python3-venv"
if command -v ldconfig >/dev/null 2>&1; then
    has_library libgomp.so.1 || missing="$missing libgomp1"
    # Only for speed: without them the simulator's own, slower renderer takes over.
    { has_library libEGL.so.1 && has_library libGL.so.1; } ||
        missing="$missing libegl1 libgl1 libgl1-mesa-dri"
fi
if [ -n "$missing" ]; then
    if command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ]; then
        echo "setup: apt-get install$missing"
        # shellcheck disable=SC2086 -- one word per package
        { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null; } ||
            echo "setup: apt-get could not install$missing; going on without" >&2
    else
        echo "setup: missing$missing (Debian's names); install them if a later step fails" >&2
    fi
fi

"$python" -m venv .venv
.venv/bin/pip install --quiet --disable-pip-version-check -e ".[$extra]"
echo "setup: ready; try .venv/bin/cb run reachtouch"
