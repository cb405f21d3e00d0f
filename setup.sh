#!/bin/sh
# Make .venv with cbdsl and an extra, and compile in advance:  ./setup.sh sim|dev|...
# Extras that are distributions of this clone are installed from it; dev installs all of these.
# As root on Debian, apt-get installs the packages that pip cannot provide; otherwise they are named.
set -eu
cd "$(dirname "$0")"
extra="${1:-sim}"

fail() { echo "setup: $1" >&2; exit 1; }
# Names in the table of extras.
extras=$(sed -n '/^\[project.optional-dependencies\]/,/^\[/s/^\([a-z0-9]*\) = .*/\1/p' pyproject.toml)
for name in $(echo "$extra" | tr ',' ' '); do
    echo "$extras" | grep -qx "$name" || fail "unknown extra '$name'; allowed: $(echo "$extras" | paste -sd ' ' -)"
done
# These come with the simulated robot; MCP has tools for comparisons, which state first causes, and
# ROS 2 links of drivers.
parts=",$extra,"
case "$parts" in *,sim,*) parts="${parts}calibration,compare,mujoco,report,why," ;; esac
case "$parts" in *,mcp,*) parts="${parts}compare," ;; esac
case "$parts" in *,compare,*) parts="${parts}why," ;; esac
case "$parts" in *,ros2,*) parts="${parts}drive," ;; esac
projects="-e ." names="cbdsl[$extra]"
for project in distributions/cbdsl-*; do
    case "$parts" in *,"${project#distributions/cbdsl-}",* | *,dev,*)
        projects="$projects -e ./$project" names="$names ${project#distributions/}" ;;
    esac
done
# The experiments come with what developers need.
case ",$extra," in *,dev,*) projects="$projects -e ./reproduction" names="$names cbdsl-reproduction[dev]" ;; esac
# An ordinary user's PATH may lack ldconfig.
has_library() { PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep -q "$1"; }
is_supported() {
    "$1" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' 2>/dev/null
}
copy_openmp() {
    .venv/bin/python -m pip download --quiet --disable-pip-version-check --no-deps --only-binary :all: --dest .venv/openmp pykdtree &&
        .venv/bin/python -c 'import sys, zipfile
wheel = zipfile.ZipFile(sys.argv[1])
(name,) = (name for name in wheel.namelist() if "/libgomp" in name)
open(sys.argv[2], "wb").write(wheel.read(name))' .venv/openmp/*.whl "$1" && rm -r .venv/openmp
}

# The Python that is asked for, else the first that is supported.
python=""
set -- python3 python3.14 python3.13 python3.12 python3.11
if [ -n "${PYTHON:-}" ]; then set -- "$PYTHON"; fi
for candidate; do
    if is_supported "$candidate"; then python="$candidate"; break; fi
done
[ -n "$python" ] || fail "no supported Python in '${PYTHON:-PATH}': install 3.11 to 3.14, or name one: PYTHON=/path/to/python $0 $extra"

can_make_environments() { "$python" -c 'import ensurepip, venv' 2>/dev/null; }
packages=""
can_make_environments || packages="python3-venv"
has_library libgomp.so.1 || packages="$packages libgomp1"
# Without these, slower renderers take over.
{ has_library libEGL.so.1 && has_library libGL.so.1; } ||
    packages="$packages libegl1 libgl1 libgl1-mesa-dri"
if [ -n "$packages" ] && command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ]; then
    echo "setup: apt-get install ${packages# }"
    # One word per package.
    # shellcheck disable=SC2086
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages; } >/dev/null 2>&1 ||
        echo "setup: apt-get could not install ${packages# }; continuing without" >&2
elif [ -n "$packages" ]; then
    echo "setup: continuing without ${packages# } (names in Debian)" >&2
fi
can_make_environments || fail "$python cannot make virtual environments: install its package python3-venv"

"$python" -m venv .venv
install() { .venv/bin/python -m pip install --quiet --disable-pip-version-check "$@"; }
# Several times as fast as pip, which takes over where uv fails: it lacks pip's settings, such as another index.
install_by_uv() {
    install uv || return 1
    # One word per option.
    # shellcheck disable=SC2086
    .venv/bin/uv pip install --quiet --python .venv/bin/python $projects $names
} 2>/dev/null
install_by_pip() {
    # Left alone, pip would install the tool that builds them once for each project.
    install 'hatchling>=1.25' 'editables~=0.3'
    # shellcheck disable=SC2086
    install --no-deps --no-build-isolation $projects
    # What they need: they themselves are installed now.
    # shellcheck disable=SC2086
    install $names
}
install_by_uv || install_by_pip
for library in .venv/lib/python3.*/site-packages/cmeel.prefix/lib; do
    [ -d "$library" ] || continue
    # Pinocchio needs OpenMP and does not bring it; the wheel of pykdtree holds a copy.
    has_library libgomp.so.1 || [ -e "$library/libgomp.so.1" ] || copy_openmp "$library/libgomp.so.1" ||
        echo "setup: libgomp.so.1 is missing and could not be copied: install libgomp1" >&2
    # Its problems are printed, and only cost time later.
    .venv/bin/cb warm || true
done
echo "setup: ready; try .venv/bin/cb run reachtouch"
