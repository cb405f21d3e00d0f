"""Finding backends by name."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest

from cbdsl.backends import backend as backend_module
from cbdsl.backends.backend import GROUP, BackendError, find_backend


def _install(monkeypatch: pytest.MonkeyPatch, **values: str) -> None:
    points = [EntryPoint(name, value, GROUP) for name, value in values.items()]
    monkeypatch.setattr(backend_module, "entry_points", lambda group: points)


def test_the_project_installs_bullet() -> None:
    from cbdsl.backends.bullet.backend import BulletBackend

    assert find_backend("bullet") is BulletBackend


def test_an_unknown_name_lists_the_known_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, mirror="a:b", anvil="c:d")
    with pytest.raises(BackendError, match=r"'bulet'.*anvil, mirror"):
        find_backend("bulet")


def test_a_missing_package_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, far="cbdsl.no_such_module:Backend")
    with pytest.raises(BackendError, match=r"no_such_module.*cbdsl\[sim\]"):
        find_backend("far")


def test_backends_of_others_are_not_mended_by_installing_ours(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _install(monkeypatch, far="no_such_package.module:Backend")
    with pytest.raises(BackendError, match=r"no_such_package'$"):
        find_backend("far")


def test_a_class_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, odd="cbdsl.backends.backend:Backand")
    with pytest.raises(BackendError, match=r"'odd'.*Backand"):
        find_backend("odd")


def test_what_is_no_backend_says_what_it_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, tuple="builtins:tuple")
    with pytest.raises(BackendError, match="reset, observe, apply, step, halt, close"):
        find_backend("tuple")
