"""Outcomes of the actions of an exploration, and the features that predict them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

from cbdsl.learning.impedance import UNTESTED, ImpedanceProfile
from cbdsl.storage.journal import RowForm

#: Action without cost and without information.
NOOP = "noop"


class FeatureForm(NamedTuple):
    """Form of a feature in an affordance model.

    Attributes:
        name: Name in the catalog.
        unit: Unit of the components.
        size: Number of components.
    """

    name: str
    unit: str
    size: int


@dataclass(frozen=True)
class ActionOutcome:
    """Outcome of one action, a row of the journal of an exploration.

    It is no record of an episode: an action may be ``noop``, or unable to begin. The features of
    all known actions, from which models predict rewards, take the place of its transitions.

    Attributes:
        action: Name of the action.
        rewarded: True if the action was rewarded by Eq 4.4.
        features: Components of the features that were defined at its activation, in SI, by name.
        opened: Actions that became possible, such as the inspection of a mark that was seen.
        ahead: Features of each known action that were defined when this action ended.
        ending: Description of the end, as a sentence.
        failed: True if the action could not be run.
        sim_seconds: Simulated duration, s.
        wall_seconds: Wall time, s; for display only.
        profile: Impedance of two objects, if the action tests it.
    """

    action: str
    rewarded: bool = False
    features: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    opened: tuple[str, ...] = ()
    ahead: Mapping[str, Mapping[str, tuple[float, ...]]] = field(default_factory=dict)
    ending: str = ""
    failed: bool = False
    sim_seconds: float = 0.0
    wall_seconds: float = field(default=0.0, compare=False)
    profile: ImpedanceProfile = UNTESTED

    def as_data(self) -> dict[str, Any]:
        """Return a row for JSON; the profile only if there is one."""
        row = asdict(self)
        del row["profile"]
        return row | ({"profile": self.profile.as_data()} if self.profile.tests else {})


def read_outcome(row: Mapping[str, Any]) -> ActionOutcome:
    """Return the outcome in a row of a journal.

    Raises:
        KeyError, TypeError, ValueError, AttributeError: If the row holds no outcome.
    """
    return ActionOutcome(
        action=_text(row["action"]),
        rewarded=bool(row["rewarded"]),
        features=_tuples(row["features"]),
        opened=tuple(map(_text, row["opened"])),
        ahead={name: _tuples(features) for name, features in row["ahead"].items()},
        ending=_text(row["ending"]),
        failed=bool(row["failed"]),
        sim_seconds=float(row["sim_seconds"]),
        wall_seconds=float(row.get("wall_seconds", 0.0)),
        profile=ImpedanceProfile.from_data(row.get("profile", ())),
    )


def write_outcome(outcome: ActionOutcome) -> dict[str, Any]:
    """Return the row of an outcome."""
    return {**outcome.as_data(), "wall_seconds": round(outcome.wall_seconds, 3)}


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is not text")
    return value


def _tuples(values: Mapping[str, Sequence[float]]) -> dict[str, tuple[float, ...]]:
    return {name: tuple(map(float, value)) for name, value in values.items()}


#: Rows of the journal of an exploration whose actions do not change.
ACTIONS = RowForm("exploration", "an action", read_outcome, write_outcome)
