"""Signs of the impedance of pairs of objects, measured by the hand that brought them together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from cbdsl.api.learning import ImpedanceTest
from cbdsl_reproduction.impedance_trials import PROGRAM, run_trials
from cbdsl_reproduction.judges.judge import (
    ANY,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)
from cbdsl_reproduction.thing_pairs import ALL_PAIRS, OTHER_PAIRS, PAIRS, ThingPair

# Least share of a profile's signs as in Figure 7.13. Signs of one profile depend on each other, so
# that a profile counts once.
_SIGNS = 0.8


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each profile of a pair."""
    pair = ALL_PAIRS[condition.name]
    for trial in run_trials(condition.name, seeds, body.backend, body.cameras):
        profile = trial.profile
        rights = pair.right(profile.tracked()) if profile.is_whole else []
        share = sum(rights) / len(rights) if rights else 0.0
        outcomes = {"whole": profile.is_whole, "signs": share >= _SIGNS if rights else None}
        measures = {
            f"{kind}_{unit}": 1e3 * max(abs(size) for size in sizes)
            for kind, unit, sizes in (
                ("displacement", "mm", [t.displacement for t in _of(profile.tests, "P")]),
                ("displacement", "mrad", [t.displacement for t in _of(profile.tests, "R")]),
                ("residue", "mm", [t.residue for t in _of(profile.tests, "P")]),
            )
            if sizes
        }
        if rights:
            measures["signs_percent"] = 100 * share
        yield EpisodeVerdict(trial.seed, outcomes, trial.sim_seconds, trial.ending, measures)


def _of(tests: Sequence[ImpedanceTest], kind: str) -> list[ImpedanceTest]:
    """Return the tests of positions (``P``) or of rotations (``R``)."""
    return [test for test in tests if test.direction[1] == kind]


def conditions(pairs: Mapping[str, ThingPair]) -> tuple[JudgedCondition, ...]:
    """Return a condition for each pair."""
    return tuple(
        JudgedCondition(
            name, PROGRAM, {"whole": ANY, "signs": Aim(_SIGNS)}, pair.stage, name, pair.values
        )
        for name, pair in pairs.items()
    )


JUDGE = Judge(
    "impedance",
    "signs of the impedance of six pairs, and of six held-out ones",
    conditions({**PAIRS, **OTHER_PAIRS}),
    _measure,
    BodyChoice("mujoco", "ideal"),
    episodes=5,
)
