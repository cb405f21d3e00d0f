"""Whether shipped catalogs predict rewards by features better than by their base rates.

In each scene the robot looks, the catalog predicts the probability of reward of one action, and the
robot takes it. The Brier score is the mean square of the probability minus the outcome.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cbdsl_reproduction.judges.judge import (
    ANY,
    BodyChoice,
    EpisodeVerdict,
    Judge,
    JudgedCondition,
    Score,
)

_OWN, _BASE = "brier", "base_rate_brier"
_CATALOGS = ("table", "basketball", "red_ball")


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each scene, whose number is its seed."""
    from cbdsl.api.simulation.expect import expect

    predictions = expect(
        condition.name,
        condition.stage,
        seed=0,
        scenes=seeds,
        backend=body.backend,
        cameras=body.cameras,
    )
    # The Brier score is proper: its expected value is least for the true probability. A catalog
    # whose features carry no information scores no better than the base rate.
    for each in predictions:
        yield EpisodeVerdict(
            each.scene,
            {"rewarded": each.rewarded, "unknown": not each.known},
            float("nan"),
            f"{each.action}: {each.probability:.2f} predicted",
            {
                _OWN: (each.probability - each.rewarded) ** 2,
                _BASE: (each.base - each.rewarded) ** 2,
            },
            each.action,
        )


JUDGE = Judge(
    "catalogs",
    "rewards that the shipped catalogs predict by features",
    tuple(
        JudgedCondition(name, "searchtrack", {"rewarded": ANY, "unknown": ANY}, f"exploring_{name}")
        for known in _CATALOGS
        for name in (known, f"{known}_and_pad")
    ),
    _measure,
    BodyChoice("mujoco", "ideal"),
    episodes=40,
    scores=(Score("Brier score", _OWN, _BASE),),
    knowledge=tuple(f"catalogs/{name}{pad}.yaml" for name in _CATALOGS for pad in ("", "_and_pad")),
)
