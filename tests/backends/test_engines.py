"""The engine of a command that names none, and the advice for one that is not installed."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Collection, Iterable

import pytest
from packaging.requirements import Requirement

from cbdsl.backends import engines
from tests.conftest import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
DISTRIBUTIONS = {"bullet": {"pybullet", "pybullet-arm64"}, "mujoco": {"cbdsl-mujoco"}}
VERSIONS = ("3.11", "3.12", "3.13", "3.14")


def show(monkeypatch: pytest.MonkeyPatch, names: Collection[str]) -> None:
    """Make exactly these engines look installed."""
    monkeypatch.setattr(engines, "find_spec", lambda module: module if module in names else None)


@pytest.mark.parametrize(
    ("modules", "engine"),
    [
        ({"pybullet", "cbdsl_mujoco", "pinocchio"}, "bullet"),
        ({"cbdsl_mujoco", "pinocchio"}, "mujoco"),
        ({"pinocchio"}, "kinematic"),
        (set(), "kinematic"),
    ],
)
def test_default_engine_is_the_first_installed_one(
    monkeypatch: pytest.MonkeyPatch, modules: set[str], engine: str
) -> None:
    show(monkeypatch, modules)
    assert engines.default_engine() == engine


def test_remedy_names_the_extra_and_the_installed_engines(monkeypatch: pytest.MonkeyPatch) -> None:
    show(monkeypatch, {"pybullet", "pinocchio"})
    expected = "try: pip install 'cbdsl[mujoco]'; installed: bullet, kinematic"
    assert engines.remedy("mujoco") == expected


def test_remedy_proposes_no_engine_without_wheels(monkeypatch: pytest.MonkeyPatch) -> None:
    show(monkeypatch, {"cbdsl_mujoco", "pinocchio"})
    monkeypatch.setattr(sys, "version_info", (3, 14, 0))
    expected = "it has no wheels for Python 3.14; installed: mujoco, kinematic"
    assert engines.remedy("bullet") == expected
    assert engines.extra_advice("ros2") == "it has no wheels for Python 3.14"


def required(extras: Iterable[str], python: str) -> set[str]:
    """Return distributions that extras install on a version of Python, with nested extras."""
    found: set[str] = set()
    for extra in extras:
        for requirement in map(Requirement, EXTRAS[extra]):
            place = {"python_version": python, "platform_machine": "x86_64"}
            if requirement.marker is None or requirement.marker.evaluate(place):
                found.add(requirement.name)
                found |= required(requirement.extras if requirement.name == "cbdsl" else (), python)
    return found


@pytest.mark.parametrize("python", VERSIONS)
@pytest.mark.parametrize("extra", EXTRAS)
def test_extras_bring_no_engine_unless_they_are_named_for_it(extra: str, python: str) -> None:
    brought = required([extra], python)
    engines_brought = {name for name, all_ in DISTRIBUTIONS.items() if all_ & brought}
    wheels = set() if python == "3.14" else {"bullet"}
    allowed = {"mujoco": {"mujoco"}, **dict.fromkeys(("sim", "dev", "fuzz", "bullet"), wheels)}
    assert engines_brought == allowed.get(extra, set())
    assert len(DISTRIBUTIONS["bullet"] & brought) <= 1


def test_each_engine_has_an_extra() -> None:
    assert set(engines.MODULES) <= set(EXTRAS)


def test_classifiers_state_the_tested_versions() -> None:
    prefix = "Programming Language :: Python :: 3."
    stated = {each for each in PROJECT["classifiers"] if each.startswith(prefix)}
    assert stated == {f"Programming Language :: Python :: {version}" for version in VERSIONS}
