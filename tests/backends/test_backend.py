"""Diagnostic backends by name."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from cbdsl.backends.backend import BACKENDS, BackendError, find_backend
from tests.plugins.installed import on_path, write_package


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    BACKENDS.refresh()
    with on_path(tmp_path):
        yield tmp_path
    BACKENDS.refresh()


def test_bullet_is_built_in() -> None:
    from cbdsl.backends.bullet.backend import BulletBackend

    assert find_backend("bullet") is BulletBackend


def test_import_of_an_engine_prints_nothing() -> None:
    script = "from cbdsl.backends.backend import find_backend; find_backend('bullet')"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_unknown_name_lists_the_known_ones(folder: Path) -> None:
    write_package(folder, "far", {BACKENDS.group: {"mirror": "far:Mirror"}})
    with pytest.raises(BackendError, match=r"'bulet'.*bullet, kinematic, mirror, mujoco, ros2"):
        find_backend("bulet")


def test_find_backend_without_its_package_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    BACKENDS.refresh()
    monkeypatch.setitem(BACKENDS._builtins, "bullet", "cbdsl.no_such_module:Backend")
    with pytest.raises(BackendError, match=r"no_such_module.*cbdsl\[bullet\]"):
        find_backend("bullet")


def test_without_mujoco_its_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    BACKENDS.refresh()
    monkeypatch.setattr(BACKENDS, "_offers", {})
    with pytest.raises(BackendError, match=r"'mujoco' comes with cbdsl\[mujoco\].*pip install"):
        find_backend("mujoco")
    BACKENDS.refresh()


def test_missing_package_of_a_plugin_backend_names_no_extra_of_cbdsl(folder: Path) -> None:
    write_package(folder, "far", {BACKENDS.group: {"far": "no_such_package.module:Backend"}})
    with pytest.raises(BackendError, match=r"package far 1.0.*no_such_package'$"):
        find_backend("far")


def test_missing_class_of_an_entry_point_is_named(folder: Path) -> None:
    write_package(folder, "far", {BACKENDS.group: {"odd": "cbdsl.backends.backend:Backand"}})
    with pytest.raises(BackendError, match=r"'odd'.*Backand"):
        find_backend("odd")


def test_class_without_backend_methods_is_refused_with_their_names(folder: Path) -> None:
    write_package(folder, "far", {BACKENDS.group: {"tuple": "builtins:tuple"}})
    with pytest.raises(BackendError, match="reset, observe, apply, step, halt, close"):
        find_backend("tuple")
