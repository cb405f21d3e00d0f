"""Results of judges as data: counts with exact intervals, and how to repeat them."""

from __future__ import annotations

import math
import shlex
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import cbdsl
from cbdsl.api.trials import versions
from cbdsl_reproduction.interval import exact_interval
from cbdsl_reproduction.judges.judge import EpisodeVerdict, JudgedCondition, Score
from cbdsl_reproduction.judges.judging import Campaign, Verdicts
from cbdsl_reproduction.judges.row_digests import row_digests

# Largest number of episodes that a row lists as amiss.
_MOST = 20
# Largest difference of equal scores of an episode, which rounding causes.
_EQUAL = 1e-9


def result_of(campaign: Campaign, verdicts: Verdicts) -> dict[str, Any]:
    """Return the result of a campaign as data for JSON."""
    rows = [
        {**row, "digests": digests_in(campaign, condition)}
        for condition in campaign.conditions
        for row in (
            *_rows(condition, verdicts),
            *_scores(campaign.judge.scores, condition, verdicts),
        )
    ]
    return {
        "judge": campaign.judge.name,
        "title": campaign.judge.title,
        **run_of(campaign),
        "met": all(row["met"] for row in rows),
        "rows": rows,
        "measures": {
            condition.name: _measures(verdicts[condition.name]) for condition in campaign.conditions
        },
    }


def run_of(campaign: Campaign) -> dict[str, Any]:
    """Return the setting of a campaign as data for JSON."""
    body = campaign.body
    return {
        "command": command_of(campaign),
        "commit": commit(),
        "versions": dict(versions(body.backend)),
        "backend": body.backend,
        "cameras": body.cameras,
        "seed": campaign.seed,
        "episodes": campaign.episodes,
    }


def digests_in(campaign: Campaign, condition: JudgedCondition) -> dict[str, str]:
    """Return the digests of all that the rows of a condition depend on."""
    return dict(row_digests(campaign.judge, condition, campaign.body.backend))


def command_of(campaign: Campaign) -> str:
    """Return the command that repeats a campaign."""
    words = ["cb", "judge", campaign.judge.name]
    words += ["--seed", str(campaign.seed), "--episodes", str(campaign.episodes)]
    words += ["--backend", campaign.body.backend]
    if campaign.body.cameras is not None:
        words += ["--cameras", campaign.body.cameras]
    if campaign.conditions != campaign.judge.conditions:
        for condition in campaign.conditions:
            words += ["--only", condition.name]
    return shlex.join(words)


def commit() -> str | None:
    """Return the commit of the checkout of cbdsl, with ``-dirty`` after changes to its files.

    It is ``None`` without git, and if cbdsl is installed from elsewhere.
    """
    folder = Path(cbdsl.__file__).resolve().parent
    describe = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=12"]
    # An installed copy may lie within the checkout of another project, whose commit would mislead.
    tracked = ["git", "-C", str(folder), "ls-files", "--error-unmatch", "__init__.py"]
    try:
        subprocess.run(tracked, capture_output=True, check=True)
        described = subprocess.run(
            [*describe, "--exclude=*"], capture_output=True, check=True, text=True
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return described.stdout.strip() or None


def _rows(condition: JudgedCondition, verdicts: Verdicts) -> Iterator[dict[str, Any]]:
    """Yield the count of each outcome of a condition."""
    own = verdicts[condition.name]
    for outcome, aim in condition.aims.items():
        counted = [each for each in own if each.outcomes[outcome] is not None]
        successes = sum(bool(each.outcomes[outcome]) for each in counted)
        # An outcome with a least share is amiss if it is absent; one with a largest share, if
        # present.
        amiss = [each for each in counted if bool(each.outcomes[outcome]) is not aim.is_least]
        yield {
            "condition": condition.name,
            "program": condition.program,
            "outcome": outcome,
            "successes": successes,
            "n": len(counted),
            "interval": _interval(successes, len(counted)),
            "aim": str(aim),
            "met": aim.is_met(successes, len(counted)),
            "amiss": [[each.context, each.seed, each.ending] for each in amiss[:_MOST]],
        }


def _scores(
    scores: Sequence[Score], condition: JudgedCondition, verdicts: Verdicts
) -> Iterator[dict[str, Any]]:
    """Yield the mean of each score of a condition, with that of its baseline."""
    measures = [verdict.measures for verdict in verdicts[condition.name]]
    for score in scores:
        # Both scores are of the same episodes. Their differences vary less than either score alone.
        pairs = [(each[score.measure], each[score.baseline]) for each in measures]
        own, baseline = (sum(column) / len(pairs) for column in zip(*pairs, strict=True))
        # Equal predictions tie. A tie misses the aim, although rounding may separate the means.
        is_tie = all(math.isclose(mine, other, abs_tol=_EQUAL) for mine, other in pairs)
        yield {
            "condition": condition.name,
            "program": condition.program,
            "outcome": score.name,
            "result": f"{own:.4f}, baseline {baseline:.4f}" + (" (tie)" if is_tie else ""),
            "episodes": len(pairs),
            "interval": _difference([mine - other for mine, other in pairs]),
            "aim": "below the baseline",
            "met": own < baseline and not is_tie,
            "amiss": [],
        }


def _difference(differences: Sequence[float]) -> list[float]:
    """Return the normal 95 % interval of a mean difference."""
    import numpy as np

    own = np.array(differences)
    error = 1.96 * own.std(ddof=1) / math.sqrt(len(own)) if len(own) > 1 else math.inf
    return [round(float(own.mean() + side * error), 6) for side in (-1, 1)]


def _interval(successes: int, count: int) -> list[float]:
    """Return the exact 95 % interval of a share; all shares without episodes."""
    return [round(end, 6) for end in exact_interval(successes, count)] if count else [0.0, 1.0]


def _measures(verdicts: Sequence[EpisodeVerdict]) -> dict[str, list[float]]:
    """Return the median, the upper decile and the maximum of each measured quantity."""
    import numpy as np

    samples: dict[str, list[float]] = {}
    for verdict in verdicts:
        timed = {"simulated_s": verdict.seconds, **verdict.measures}
        for name, value in timed.items():
            if math.isfinite(value):
                samples.setdefault(name, []).append(value)
    return {
        name: [round(float(value), 3) for value in np.quantile(own, [0.5, 0.9, 1.0])]
        for name, own in samples.items()
    }
