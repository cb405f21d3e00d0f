"""Undefined features are looked for one after the other, before the first choice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

import pytest

from cbdsl.runtime.action_levels import Active
from cbdsl.runtime.context_reader import ContextReader, FeatureLooks


class ScriptedLook:
    """A program that ends at its second tick, and may define its feature then."""

    def __init__(self, defined: dict[str, bool], feature: str, *, finds: bool = True) -> None:
        self.predicate, self.ticks = "X", 0
        self._defined, self._feature, self._finds = defined, feature, finds

    def activate(self) -> None:
        self.predicate, self.ticks = "0", 0

    def deactivate(self) -> None:
        self.predicate = "X"

    def advance(self) -> None:
        self.ticks += 1
        if self.ticks == 2:
            self.predicate = "1" if self._finds else "-"
            self._defined[self._feature] = self._finds

    def active(self) -> Sequence[Active]:
        return ()


class ScriptedContext:
    """Features that are defined or not."""

    def __init__(self, defined: Mapping[str, bool]) -> None:
        self._defined = defined

    def lacks(self, feature: str) -> bool:
        return not self._defined[feature]


def looks(
    defined: dict[str, bool], finds: bool = True
) -> tuple[FeatureLooks, dict[str, ScriptedLook]]:
    programs = {name: ScriptedLook(defined, name, finds=finds) for name in defined}
    return FeatureLooks(programs, cast("ContextReader", ScriptedContext(defined))), programs


@pytest.mark.parametrize("finds", [True, False])
def test_undefined_features_are_looked_for_once_in_order(*, finds: bool) -> None:
    own, programs = looks({"place": False, "volume": True, "speed": False}, finds)
    assert own.begin()
    order = []
    for _ in range(4):
        current = own.current
        assert current is not None and current.predicate == "0"
        order.append(current)
        goes_on = own.advance(current)
    assert order == [programs["place"]] * 2 + [programs["speed"]] * 2
    assert not goes_on and own.current is None
    assert {each.predicate for each in programs.values()} == {"X"}


def test_feature_defined_during_a_look_is_not_looked_for() -> None:
    defined = {"place": False, "volume": False}
    own, programs = looks(defined)
    assert own.begin()
    defined["volume"] = True
    assert own.advance(programs["place"]) and not own.advance(programs["place"])
    assert programs["volume"].ticks == 0


def test_no_look_begins_if_all_features_are_defined_or_after_a_reset() -> None:
    own, _ = looks({"place": True})
    assert not own.begin() and own.current is None
    own, programs = looks({"place": False, "speed": False})
    own.begin()
    own.forget()
    assert own.current is None
    assert not FeatureLooks(programs, None).begin()
