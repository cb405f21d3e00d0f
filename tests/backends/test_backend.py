"""Finding backends by name."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest

from cbdsl.backends import backend as backend_module
from cbdsl.backends.backend import GROUP, BackendError, find_backend


def _install(monkeypatch: pytest.MonkeyPatch, **values: str) -> None:
    points = [EntryPoint(name, value, GROUP) for name, value in values.items()]
    monkeypatch.setattr(backend_module, "entry_points", lambda group: points)


def test_finds_what_an_entry_point_names(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, tuple="builtins:tuple")
    assert find_backend("tuple") is tuple


def test_the_project_installs_bullet() -> None:
    from cbdsl.backends.bullet.backend import BulletBackend

    assert find_backend("bullet") is BulletBackend


def test_an_unknown_name_lists_the_known_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, mirror="a:b", anvil="c:d")
    with pytest.raises(BackendError, match=r"'bulet'.*anvil, mirror"):
        find_backend("bulet")


def test_a_missing_package_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, far="no_such_package.module:Backend")
    with pytest.raises(BackendError, match=r"no_such_package.*cbdsl\[sim\]"):
        find_backend("far")
