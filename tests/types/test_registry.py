"""Registries of built-in entries and of plug-ins, with distributions as installers leave them."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.types.registry import PluginError, Registry, require_function
from tests.plugins.installed import on_path, write_package

GROUP = "cbdsl.tests"


def _number(_: str, found: Any) -> float:
    if not isinstance(found, float):
        raise PluginError(f"is {type(found).__name__}, not a number")
    return found


@pytest.fixture
def registry() -> Registry[float]:
    return Registry("number", GROUP, {"pi": "math:pi", "tau": "math:tau"}, _number)


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    with on_path(tmp_path):
        yield tmp_path


def test_built_in_entries_are_imported_at_their_first_use(registry: Registry[float]) -> None:
    assert registry.names() == ("pi", "tau")
    assert registry.get("tau") == pytest.approx(6.283, abs=1e-3)
    assert registry.package("tau") == "cbdsl"


def test_package_adds_an_entry(registry: Registry[float], folder: Path) -> None:
    write_package(folder, "greek", {GROUP: {"phi": "greek:phi"}}, greek="phi = 1.618")
    assert registry.get("phi") == 1.618
    assert registry.package("phi") == "greek 1.0"
    assert list(registry.all()) == ["pi", "tau", "phi"]
    assert registry.faults() == ()


def test_unknown_name_has_the_nearest_and_all_known_ones(registry: Registry[float]) -> None:
    with pytest.raises(
        UsageError, match=r"unknown number 'tua'; did you mean 'tau'.*known: pi, tau"
    ):
        registry.get("tua")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import no_such_module", "No module named 'no_such_module'"),
        ("phi = ", "SyntaxError"),
        ("1 / 0", "ZeroDivisionError"),
        ("import sys; sys.exit(3)", "SystemExit: 3"),
        ("psi = 2.0", "no attribute 'phi'"),
        ("phi = 'golden'", "is str, not a number"),
    ],
)
def test_faulty_plugin_is_named_and_takes_nothing_else_down(
    registry: Registry[float], folder: Path, text: str, reason: str
) -> None:
    write_package(folder, "greek", {GROUP: {"phi": "greek:phi"}}, greek=text)
    write_package(folder, "latin", {GROUP: {"unit": "latin:unit"}}, latin="unit = 1.0")
    assert registry.all().keys() == {"pi", "tau", "unit"}
    (fault,) = registry.faults()
    assert str(fault).startswith(f"number 'phi' (package greek 1.0, group {GROUP}): ")
    assert reason in str(fault)
    with pytest.raises(PluginError) as raised:
        registry.get("phi")
    assert str(raised.value) == str(fault)


def test_plugin_that_fails_is_imported_once(registry: Registry[float], folder: Path) -> None:
    log = folder / "log"
    text = f"open({str(log)!r}, 'a').write('.')\n1 / 0"
    write_package(folder, "greek", {GROUP: {"phi": "greek:phi"}}, greek=text)
    for _ in range(2):
        registry.faults()
    assert log.read_text() == "."


def test_built_in_name_is_not_taken(registry: Registry[float], folder: Path) -> None:
    write_package(folder, "greek", {GROUP: {"tau": "greek:tau"}}, greek="tau = 0.0")
    assert registry.get("tau") > 6
    (fault,) = registry.faults()
    assert "'tau' (package greek 1.0" in str(fault)
    assert "built in" in str(fault)


def test_two_packages_with_one_name_are_both_named(registry: Registry[float], folder: Path) -> None:
    for name in ("greek", "hellenic"):
        write_package(folder, name, {GROUP: {"phi": f"{name}:phi"}}, **{name: "phi = 1.6"})
    (fault,) = registry.faults()
    assert "greek 1.0" in str(fault)
    assert "hellenic 1.0" in str(fault)
    assert "phi" not in registry.all()


def test_packages_that_come_later_count_after_a_refresh(
    registry: Registry[float], folder: Path
) -> None:
    assert "phi" not in registry
    write_package(folder, "greek", {GROUP: {"phi": "greek:phi"}}, greek="phi = 1.618")
    assert "phi" not in registry
    registry.refresh()
    assert "phi" in registry


def test_built_in_entries_cost_no_metadata() -> None:
    code = (
        "import sys; from cbdsl.types.registry import Registry\n"
        "r = Registry('number', 'g', {'pi': 'math:pi'}, lambda _, x: x)\n"
        "r.get('pi'); 'pi' in r\n"
        "assert 'importlib.metadata' not in sys.modules\n"
        "'po' in r\n"
        "assert 'importlib.metadata' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_built_in_entries_without_import_are_found_like_all_others(folder: Path) -> None:
    registry = Registry("number", GROUP, {"pi": "math:pi"}, _number, {"half": 0.5})
    assert registry.names() == ("half", "pi") and registry.is_builtin("half")
    assert registry.get("half") == 0.5 and list(registry.all()) == ["half", "pi"]
    registry.refresh()
    assert registry.get("half") == 0.5
    write_package(folder, "greek", {GROUP: {"half": "greek:half"}}, greek="half = 1.5")
    registry.refresh()
    assert registry.get("half") == 0.5
    (fault,) = registry.faults()
    assert "this name is built in" in str(fault)


def test_registry_of_potentials_returns_the_built_in_ones() -> None:
    from cbdsl.types.potential import POTENTIALS

    assert POTENTIALS.registry.all() == dict(POTENTIALS)


def test_require_function_of_another_object_is_refused_with_its_type() -> None:
    with pytest.raises(PluginError, match="is a int, and no function"):
        require_function("count", 3)
