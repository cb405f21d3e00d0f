"""Touching with both hands as printed (Section 4.3.3), by the mount of the arms."""

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
from cbdsl_reproduction.mounts.arm_mount import TODAY
from cbdsl_reproduction.mounts.mounted_touch import read_opposed, run_episodes

_DEXTER, _OPPOSED = "Dexter", "opposed palms"


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each episode of a mount."""
    mount, postures = (TODAY, None) if condition.name == _DEXTER else read_opposed()
    for each in run_episodes(mount, *body, seeds, postures=postures):
        outcomes = {
            "taken": each.taken,
            "met": each.met,
            "rewarded with both hands on it": each.rewarded and each.both,
        }
        measures = {"palms_cm": 100 * each.apart} if each.taken else {}
        yield EpisodeVerdict(each.seed, outcomes, each.seconds, each.ending, measures)


_REWARDED = "rewarded with both hands on it"
JUDGE = Judge(
    "mounted_touch",
    "BIMANUALTOUCH as printed, by the mount of the arms",
    (
        JudgedCondition(_DEXTER, "", {"taken": ANY, "met": ANY, _REWARDED: ANY}),
        JudgedCondition(_OPPOSED, "", {"taken": ANY, "met": ANY, _REWARDED: Aim(0.9)}),
    ),
    _measure,
    BodyChoice("mujoco", "ideal"),
)
