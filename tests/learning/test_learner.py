"""Registered learners have the members of the contract."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from cbdsl.documents.document import Section
from cbdsl.learning.learner import LEARNERS
from cbdsl.types.registry import PluginError, Registry

METHODS = ("see", "remember", "policy", "greedy", "densities", "documents")


class Needy(Section):
    """Constants of which one has no default."""

    alpha: float


def offered(monkeypatch: pytest.MonkeyPatch, **without: object) -> Any:
    """Return a registered class with all members of a learner, except for some."""
    whole = {**dict.fromkeys(METHODS, lambda: None), "Constants": Section, **without}
    monkeypatch.setattr(sys.modules[__name__], "Offered", type("Offered", (), whole))
    registry: Any = Registry("learner", "none", {"it": f"{__name__}:Offered"}, LEARNERS._validate)
    return registry.get("it")


Offered: Any = None


@pytest.mark.parametrize("lacking", [*METHODS, "Constants"])
def test_class_that_lacks_something_is_no_learner(
    lacking: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert offered(monkeypatch) is Offered
    with pytest.raises(PluginError, match=lacking):
        offered(monkeypatch, **{lacking: None})


def test_constants_of_a_learner_have_defaults(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(PluginError, match="no default: alpha"):
        offered(monkeypatch, Constants=Needy)
