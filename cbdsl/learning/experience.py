"""Experience: finished episode in the form that learners use and journals store."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from cbdsl.learning.impedance import UNTESTED, ImpedanceProfile
from cbdsl.program.transition import Transition
from cbdsl.storage.journal import RowForm


@dataclass(frozen=True)
class Experience:
    """Finished episode in the form that learners use, a row of the journal of a trial.

    It is no ``EpisodeResult``. Journals store neither names nor reasons of endings, and results
    store no transitions, so that neither can be read as the other.

    Attributes:
        context: Name of the stage's context.
        seed: Random seed of the episode.
        transitions: Transitions of the learned program, in order.
        rewarded: Configuration of each effector when a controller that moves it earned the reward,
            rad.
        ticks: Number of control ticks.
        sim_seconds: Simulated time, s.
        wall_seconds: Wall time, s; for display only.
        profile: Impedance of two objects, if the program tests it.
        relation: Relation of the objects as the stage names it; empty if it does not.
    """

    context: str
    seed: int
    transitions: tuple[Transition, ...]
    rewarded: Mapping[str, tuple[float, ...]]
    ticks: int
    sim_seconds: float
    wall_seconds: float = field(default=0.0, compare=False)
    profile: ImpedanceProfile = UNTESTED
    relation: str = ""

    @property
    def reward(self) -> int:
        """Sum of the rewards of its transitions."""
        return sum(transition.reward for transition in self.transitions)

    @property
    def rewarding(self) -> tuple[str, ...]:
        """Members that earned the reward."""
        return tuple(name for transition in self.transitions for name in transition.rewarding)

    @property
    def end(self) -> str:
        """State that it ended in."""
        return self.transitions[-1].next_state


def _read(row: Mapping[str, Any]) -> Experience:
    transitions = (
        Transition(**fields | {key: tuple(fields.get(key, ())) for key in ("rewarding", "stuck")})
        for fields in row["transitions"]
    )
    return Experience(
        context=row["context"],
        seed=row["seed"],
        transitions=tuple(transitions),
        rewarded={effector: tuple(angles) for effector, angles in row["rewarded"].items()},
        ticks=row["ticks"],
        sim_seconds=row["sim_seconds"],
        wall_seconds=row["wall_seconds"],
        profile=ImpedanceProfile.from_data(row.get("profile", ())),
        relation=row.get("relation", ""),
    )


def _write(experience: Experience) -> dict[str, Any]:
    row = {**asdict(experience), "wall_seconds": round(experience.wall_seconds, 3)}
    del row["profile"], row["relation"]
    if not experience.profile.tests:
        return row
    return {**row, "profile": experience.profile.as_data(), "relation": experience.relation}


#: Rows of the journal of a trial.
EPISODES = RowForm("trial", "an episode", _read, _write)
