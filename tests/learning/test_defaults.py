"""Defaults of constants keep their own bounds, and equal the constants of measured results."""

from __future__ import annotations

from typing import Any

import pytest

from cbdsl.documents.document import Section
from cbdsl.learning.catalogs.explorations import EXPLORATIONS
from cbdsl.learning.learner import LEARNERS

#: Of explorations the algorithms' constants, which no page lists; the reference has the others.
MEASURED = {
    "explore_catalog": {
        "alpha": 0.3, "cost": 0.05, "prior": 1.0, "units": "workspace", "measure": "spread",
        "habituated": 0.1, "least": 3, "longest": 60.0, "temperature": 0.3, "decay": 0.96,
        "coldest": 0.02,
    },
    "explore_models": {
        "alpha": 0.3, "cost": 0.05, "prior": 1.0, "units": "workspace", "measure": "spread",
        "habituated": 0.1, "least": 3, "longest": 60.0, "gamma": 0.8, "epsilon": 0.05,
        "promise": 0.2, "surprise": 4.0,
    },
    "accommodate": {
        "gamma": 0.8, "alpha": 0.1, "epsilon": 0.2, "exploring_episodes": None,
        "density": "kernel", "bandwidth": 0.1, "prior": 10.0,
    },
    "assimilate": {
        "draws": True, "epsilon": 0.2, "blames_first": False, "least_samples": 2,
        "least_attempts": 3, "least_reward": 0.5,
    },
}  # fmt: skip
ALL: dict[str, type[Section]] = {
    name: each.Constants for name, each in {**LEARNERS.all(), **EXPLORATIONS}.items()
}


@pytest.mark.parametrize("constants", ALL.values(), ids=ALL)
def test_defaults_are_allowed_values(constants: type[Section]) -> None:
    given: dict[str, Any] = {
        name: value for name, value in constants().model_dump().items() if value is not None
    }
    assert constants.model_validate(given) == constants()


@pytest.mark.parametrize("name", MEASURED)
def test_defaults_equal_the_constants_of_the_measurements(name: str) -> None:
    assert ALL[name]().model_dump() == MEASURED[name]
