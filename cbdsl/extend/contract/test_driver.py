"""Contract of kinds of drivers: rules for addresses, and the methods of links."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from inspect import isclass
from typing import Any

import pytest

from cbdsl.backends.driver_link import DriverLink
from cbdsl.documents.driver import Driver
from cbdsl.robot.driver_kind import DRIVERS

KINDS = pytest.mark.parametrize("name", DRIVERS.usable_names())
_METHODS = [name for name in vars(DriverLink) if not name.startswith("_")]


def _value(section: Any, steps: tuple[str, ...]) -> object:
    """Return the value of a section at a path."""
    for step in steps:
        section = section[step] if isinstance(section, Mapping) else getattr(section, step)
    return section


@KINDS
def test_problems_of_odd_addresses_are_reasons_at_keys_of_the_section(name: str) -> None:
    keys = {"kind": name, "moves": ["arm"], "options": {"none": 1}}
    for address in ("?", " ", "a" * 10_000, "/ok", "\N{SNOWMAN}"):
        driver = Driver.model_validate(
            {**keys, "states": address, "commands": address, "images": {"left": address}}
        )
        for steps, reason in DRIVERS.get(name).problems(driver):
            _value(driver, steps)
            assert reason and not reason.endswith(".")


@KINDS
def test_link_of_a_kind_has_all_methods(name: str) -> None:
    module, _, attribute = DRIVERS.get(name).link.partition(":")
    try:
        link = getattr(import_module(module), attribute)
    except ModuleNotFoundError as error:
        pytest.skip(f"{error.name} is not installed")
    assert callable(link)
    assert not isclass(link) or [each for each in _METHODS if not hasattr(link, each)] == []
