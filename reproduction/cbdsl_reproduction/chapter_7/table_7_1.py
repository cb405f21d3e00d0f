"""Stability of stacks of two and of three objects (Tables 7.1 and 7.2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from statistics import median

from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.kept_trials import kept_trials
from cbdsl_reproduction.percentage import percentage, same_percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.stack_trials import StackTrial, run_stacks, stack_digest

# Number of trials of the source for each stack.
_THERE = 5
_TRIALS, _FLAT_TRIALS, _QUICK_TRIALS = 40, 80, 1
_FLAT = "purple_box_on_blue_box"

#: Stacks, and the printed percentages; ``None`` for stacks that the source does not have.
STACKS: Mapping[str, int | None] = {
    _FLAT: 100,
    "basketball_on_blue_box": 20,
    "football_on_blue_box": 80,
    "basketball_on_purple_box": 0,
    "football_on_purple_box": 40,
    "basketball_on_football": 0,
    "football_on_basketball": 0,
    "purple_box_on_basketball": None,
    "purple_box_on_football": None,
    "basketball_on_purple_box_on_blue_box": 0,
    "football_on_purple_box_on_blue_box": 40,
    "purple_box_on_basketball_on_blue_box": 0,
    "purple_box_on_football_on_blue_box": 0,
    "basketball_on_football_on_blue_box": None,
    "football_on_basketball_on_blue_box": None,
}


def _claim(stack: str, printed: int | None) -> Claim:
    """Return the claim about a stack; percentages of five trials are multiples of 20."""
    place = f"Section 7.3.2, Table 7.{2 if stack.count('_on_') > 1 else 1}"
    name = stack.replace("_", " ")
    if printed is None:
        return Claim(place, name, "%")
    trials = (printed * _THERE // 100, _THERE)
    return Claim(place, name, "%", f"{printed} %", trials=trials)


CLAIMS: Claims = {"table-7.1-7.2": tuple(_claim(*stack) for stack in STACKS.items())}

_NOTES = (
    "A stack stands where each thing rests on the one below it alone, 1 s after it was let go at "
    "least, by the simulator's truth. Shares are of all episodes, those in which a thing was not "
    "brought to its place included. The source ran each five times. A value is missed if Fisher's "
    "exact test denies, at 5 %, that both ran the same process.",
    "The balls have a radius of 6 cm, the football corners, and rolling friction 0.4 mm. "
    "The boxes are 8 cm and 16 x 16 x 10 cm. The pace is the thing's largest speed within 0.2 s "
    "after the last fingertip left it. No friction was chosen for the source's numbers.",
)


def run(settings: RunSettings) -> Result:
    """Build all stacks."""
    trials = kept_trials(
        settings.folder / f"{settings.backend}_{settings.cameras}.jsonl",
        {name: _seeds(name, settings) for name in STACKS},
        stack_digest,
        StackTrial,
        partial(run_stacks, engine=settings.backend, cameras=settings.cameras),
        settings.progress,
    )
    return Result(tuple(_quantities(trials)), notes=_NOTES)


def _seeds(name: str, settings: RunSettings) -> range:
    usual = _QUICK_TRIALS if settings.quick else _FLAT_TRIALS if name == _FLAT else _TRIALS
    return range(settings.seed, settings.seed + (settings.trials or usual))


def _quantities(trials: Mapping[str, Sequence[StackTrial]]) -> Iterator[Quantity]:
    for name, own in trials.items():
        printed = STACKS[name]
        released = [each.pace for each in own if each.released]
        pace = f"; pace {1e3 * median(released):.0f} mm/s" if released else ""
        note, count = f"{len(released)} let go{pace}", len(own)
        judge = percentage if printed is None or count < 2 else same_percentage
        yield judge(_claim(name, printed), sum(each.stands for each in own), count, note=note)
