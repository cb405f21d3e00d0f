"""Whether stacks of the source's objects stand, at least 1 s after the release."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cbdsl_reproduction.judges.judge import (
    ANY,
    Aim,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
)

# Flat on flat has an aim; the source counts the others, too.
_FLAT = "purple_box_on_blue_box"


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each stack."""
    from cbdsl_reproduction.stack_trials import run_stacks

    for trial in run_stacks(condition.name, seeds, body.backend, body.cameras):
        outcomes = {"released": trial.released, "stands": trial.stands}
        measures = {"offset_mm": 1e3 * trial.offset, "pace_mm_s": 1e3 * trial.pace}
        yield EpisodeVerdict(
            trial.seed,
            outcomes,
            trial.seconds,
            trial.ending,
            measures if trial.released else {},
        )


def _conditions() -> tuple[JudgedCondition, ...]:
    from cbdsl_reproduction.chapter_7.table_7_1 import STACKS

    return tuple(
        JudgedCondition(
            name,
            "stack" if "_on_" in name and name.count("_on_") == 1 else "stack_three",
            {"released": ANY, "stands": Aim(0.95) if name == _FLAT else ANY},
            context=name,
        )
        for name in STACKS
    )


JUDGE = Judge(
    "stacks",
    "stacks of two and of three objects",
    _conditions(),
    _measure,
    BodyChoice("mujoco", "ideal"),
    episodes=40,
)
