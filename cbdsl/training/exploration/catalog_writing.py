"""Conversion of an exploration's knowledge and provenance to a catalog document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cbdsl.documents.catalog import (
    AffordanceSection,
    CatalogDocument,
    CatalogProvenance,
    FeatureSection,
    Habituation,
    SampleModel,
    StepColumns,
)
from cbdsl.learning.catalogs.action_outcome import ActionOutcome
from cbdsl.learning.catalogs.affordance import Affordance
from cbdsl.learning.catalogs.exploration import Exploration
from cbdsl.numeric.proportion import exact_interval
from cbdsl.numeric.sample_statistics import SampleStatistics
from cbdsl.program.checked import CheckedProgram
from cbdsl.training.exploration.explorable import Explorable
from cbdsl.types.resource import Resource


def catalog_document(
    name: str,
    feature: str,
    exploration: Exploration,
    outcomes: Sequence[ActionOutcome],
    actions: Mapping[str, Explorable],
    provenance: CatalogProvenance,
) -> CatalogDocument:
    """Return the catalog of an exploration.

    Args:
        name: Name of the catalog.
        feature: Channel of the object.
        exploration: Exploration at its end.
        outcomes: Outcomes of its actions.
        actions: Explorable actions by name.
        provenance: Provenance of the catalog.
    """
    robot = next(iter(actions.values())).program.robot
    failures = {each.action: each.ending for each in outcomes if each.failed}
    return CatalogDocument(
        cbdsl=1,
        kind="catalog",
        name=name,
        robot=robot,
        feature=feature,
        affordances={
            key: _section(key, exploration, actions[key], failures.get(key, ""))
            for key in exploration.affordances
        },
        steps=step_columns(exploration),
        provenance=provenance,
    )


def step_columns(exploration: Exploration) -> StepColumns | None:
    """Return the steps of an exploration; ``None`` if there are none."""
    steps = exploration.steps
    if not steps:
        return None
    return StepColumns(
        action=tuple(step.action for step in steps),
        rewarded=tuple(step.rewarded for step in steps),
        change=tuple(_rounded(step.change) for step in steps),
        reward=tuple(_rounded(step.reward) for step in steps),
    )


def _section(
    name: str, exploration: Exploration, action: Explorable, failure: str
) -> AffordanceSection:
    return AffordanceSection(
        **affordance_values(name, exploration, action.program, action.features, failure)
    )


def affordance_values(
    name: str,
    exploration: Exploration,
    program: CheckedProgram,
    signals: Mapping[str, Resource],
    failure: str = "",
) -> dict[str, Any]:
    """Return the knowledge of an action as values of an ``AffordanceSection``.

    Args:
        name: Name of the action.
        exploration: Exploration at its end.
        program: Program of the action.
        signals: Signals of its model, by name of the feature.
        failure: Reason why it can no longer be run; empty if it can.
    """
    affordance = exploration.affordances[name]
    model = affordance.model
    tried, rewarded = affordance.tried, affordance.successes
    values: Mapping[str, float] = getattr(exploration, "values", {})
    return {
        "program": program.name,
        "with": dict(program.parameters),
        "tried": tried,
        "rewarded": rewarded,
        "interval": _interval(rewarded, tried) if tried else None,
        "features": {
            key: FeatureSection(
                signal=signals[key].name,
                unit=signals[key].type.unit,
                components=signals[key].type.size,
            )
            for key in affordance.features
        },
        "with_reward": None if model is None else _samples(model.rewarded),
        "without_reward": None if model is None else _samples(model.unrewarded),
        "habituation": _habituation(name, exploration, affordance),
        "value": _rounded(values.get(name, 0.0)),
        "failed": failure if affordance.failed else "",
    }


def _interval(rewarded: int, tried: int) -> tuple[float, float]:
    # The interval is that of Clopper and Pearson, which holds for few trials, too.
    low, high = exact_interval(rewarded, tried)
    return _rounded(low), _rounded(high)


def _habituation(name: str, exploration: Exploration, affordance: Affordance) -> Habituation | None:
    if affordance.model is None:
        return None
    return Habituation(
        variance=_rounded(affordance.model.variance(exploration.constants.measure)),
        change=_rounded(exploration.change_of(name) or 0.0),
        habituated=exploration.is_habituated(name),
    )


def _samples(samples: SampleStatistics) -> SampleModel | None:
    """Return mean and covariance of samples; ``None`` without samples."""
    if not samples.weight:
        return None
    covariance = samples.covariance.tolist()
    return SampleModel(
        count=round(samples.weight),
        mean=tuple(map(_rounded, samples.mean.tolist())),
        covariance=tuple(tuple(map(_rounded, row)) for row in covariance),
    )


def _rounded(value: float) -> float:
    """Return a number rounded to its significant digits, the same on every machine."""
    return float(f"{value:.9g}")
