"""Hierarchy of meta-catalogs of three objects, and the resulting stack (7.16 and 7.17)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from cbdsl.api.drawing import Layer
from cbdsl_reproduction.affordance_trials import (
    AffordanceTrial,
    affordance_digest,
    attempt,
    run_affordances,
)
from cbdsl_reproduction.catalog_hierarchy import CatalogNode
from cbdsl_reproduction.chapter_7.blob_panels import BlobPanels
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.constellation_trials import (
    ConstellationTrial,
    constellation_digest,
    run_constellations,
)
from cbdsl_reproduction.experiment import Picture, Progress, Result, RunSettings
from cbdsl_reproduction.growing_stack_trials import (
    CONTEXT,
    GrowingStack,
    growing_digest,
    run_growing_stacks,
)
from cbdsl_reproduction.hierarchy import Hierarchy
from cbdsl_reproduction.kept_trials import Some, kept_trials
from cbdsl_reproduction.percentage import percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import ValueRegion, above, at_least, below

_TRIALS, _QUICK_TRIALS = 20, 1
_LOOK, _TOUCH, _BOTH = "searchtrack", "reachtouch", "bimanualtouch"
_LOWER_PAIR, _UPPER_PAIR = "purple_box_on_blue_box", "football_on_purple_box"
_STACK = "football_on_purple_box_on_blue_box"
_COLORS = {"blue_box": "#0072b2", "purple_box": "#cc79a7", "football": "#009e73"}
_TITLE = "Affordances of three objects alone and together (Figure 7.17)"
_PLACING = "pick and place"
_MOMENTS = ("as they lie", "two are stacked", "all three, after the release")


class Afforded(NamedTuple):
    """Statement of the source about one action on one object."""

    report: str
    region: ValueRegion | None


# The source states whether an action is afforded, without
# a rate, so that the majority of the trials decides.
_YES, _NO, _UNSAID = (
    Afforded("afforded", above(50)),
    Afforded("not afforded", below(50)),
    Afforded("", None),
)
#: Affordances of each object by itself (Section 7.3.2).
AFFORDED: Mapping[str, Mapping[str, Afforded]] = {
    "blue_box": {_LOOK: _YES, _TOUCH: _YES, _BOTH: _NO},
    "purple_box": {_LOOK: _YES, _TOUCH: _YES, _BOTH: _YES},
    "football": {_LOOK: _UNSAID, _TOUCH: _UNSAID, _BOTH: _UNSAID},
}

_PLACE, _GROWN = "Section 7.3.2, Figure 7.17", "Section 7.3.2, Figures 7.16 and 7.17"
_ALONE = {
    (thing, program): Claim(
        _PLACE,
        f"{thing.replace('_', ' ')}: {program} rewarded",
        "%",
        afforded.report,
        afforded.region,
    )
    for thing, own in AFFORDED.items()
    for program, afforded in own.items()
}
_PAIRS = {
    name: Claim(_GROWN, f"{name.replace('_', ' ')}: constellation tracked", "%", report, region)
    for name, report, region in ((_LOWER_PAIR, "100 %", above(50)), (_UPPER_PAIR, "40 %", None))
}
_THREE = Claim(
    _GROWN, f"{_STACK.replace('_', ' ')}: constellations tracked", "%", "40 %", at_least(40)
)
_TRUE = Claim(
    _GROWN,
    "share of truly standing stacks among those reported as standing",
    "%",
    "all",
    at_least(90),
)
CLAIMS: Claims = {"fig-7.16-7.17": (*_ALONE.values(), *_PAIRS.values(), _THREE, _TRUE)}

_NOTES = (
    "The robot judges by its own signals: an action is rewarded, or a constellation rests for a "
    "second after the hand has gone, with the upper thing above the lower one. Of three, it tracks "
    "the constellations of both pairs, and the uppermost thing is to be above the lowest: the "
    "object in between is occluded too much to be located.",
    "Blobs are the ellipses that the left camera's regions are seen as; a round one has no "
    "direction. The source shows one stack of the two that stood.",
)


@dataclass(frozen=True)
class _Trials:
    """Trials with single objects, pairs and stacks.

    Attributes:
        alone: Trials by program and object, as ``attempt`` joins them.
        pairs: Trials by name of the pair.
        stacks: Trials with stacks of three.
    """

    alone: Mapping[str, Sequence[AffordanceTrial]]
    pairs: Mapping[str, Sequence[ConstellationTrial]]
    stacks: Sequence[GrowingStack]


def run(settings: RunSettings) -> Result:
    """Act on single objects, on pairs and on all three, and draw the affordances."""
    trials = _gather(settings)
    quantities = (*_alone(trials), *_together(trials))
    pictures: list[Picture] = [
        *_growth(trials.stacks),
        Hierarchy("fig-7.17", _TITLE, _nodes(trials)),
    ]
    return Result(quantities, tuple(pictures), _NOTES)


def _gather(settings: RunSettings) -> _Trials:
    count = settings.trials or (_QUICK_TRIALS if settings.quick else _TRIALS)
    seeds = range(settings.seed, settings.seed + count)
    attempts = [attempt(program, thing) for thing, own in AFFORDED.items() for program in own]
    parts = _Parts(settings.progress, count * (len(attempts) + 3))
    settings = replace(settings, progress=parts.note)
    alone = _kept(
        settings, "affordances", dict.fromkeys(attempts, seeds), affordance_digest,
        AffordanceTrial, run_affordances,
    )  # fmt: skip
    parts.pass_by(count * len(attempts))
    pairs = _kept(
        settings, "constellations", dict.fromkeys((_LOWER_PAIR, _UPPER_PAIR), seeds),
        constellation_digest, ConstellationTrial, run_constellations,
    )  # fmt: skip
    parts.pass_by(2 * count)
    stacks = _kept(
        settings, "growing_stacks", {CONTEXT: seeds}, growing_digest,
        GrowingStack, run_growing_stacks,
    )  # fmt: skip
    return _Trials(alone, pairs, stacks[CONTEXT])


def _kept(
    settings: RunSettings,
    kind: str,
    seeds: Mapping[str, Sequence[int]],
    digest: Callable[[str], str],
    trial: type[Some],
    run_them: Callable[[str, Sequence[int], str, str | None], Iterable[Some]],
) -> dict[str, list[Some]]:
    """Return the trials of one kind, from a file or by running them."""
    path = settings.folder / f"{kind}_{settings.backend}_{settings.cameras}.jsonl"
    return kept_trials(
        path, seeds, digest, trial,
        lambda things, missing: run_them(things, missing, settings.backend, settings.cameras),
        settings.progress,
    )  # fmt: skip


class _Parts:
    """Common progress of several consecutive kinds of trials.

    Args:
        progress: Callback for the overall progress.
        total: Number of all trials.
    """

    def __init__(self, progress: Progress, total: int) -> None:
        self._progress, self._total, self._before = progress, total, 0

    def pass_by(self, count: int) -> None:
        """Count the trials of a finished kind."""
        self._before += count

    def note(self, done: int, total: int) -> None:
        """Report ``done`` finished trials of the current kind."""
        self._progress(self._before + done, self._total)


def _alone(trials: _Trials) -> Iterator[Quantity]:
    for (thing, program), claim in _ALONE.items():
        done = trials.alone[attempt(program, thing)]
        yield percentage(claim, sum(each.rewarded for each in done), len(done))


def _together(trials: _Trials) -> Iterator[Quantity]:
    """Yield the shares of tracked constellations, and of true reports of standing stacks."""
    for name, claim in _PAIRS.items():
        done = trials.pairs[name]
        hits, stood = sum(each.judged for each in done), sum(each.stands for each in done)
        yield percentage(claim, hits, len(done), note=f"{stood} stand")
    tracked = [each for each in trials.stacks if each.tracked]
    stood = sum(each.stands for each in trials.stacks)
    yield percentage(_THREE, len(tracked), len(trials.stacks), note=f"{stood} stand")
    # Only reported stacks count here: one that stands unnoticed is a miss of the shares above.
    right = [each.stands for each in tracked]
    right += [each.stands for own in trials.pairs.values() for each in own if each.judged]
    yield percentage(_TRUE, sum(right), len(right))


def _nodes(trials: _Trials) -> dict[str, CatalogNode]:
    """Return the catalogs of the objects, of the pair, and of the stack."""
    nodes = {
        thing: CatalogNode(
            thing.replace("_", " "),
            [
                _layer(program, [e.rewarded for e in trials.alone[attempt(program, thing)]])
                for program in own
            ],
        )
        for thing, own in AFFORDED.items()
    }
    pair = [each.judged for each in trials.pairs[_LOWER_PAIR]]
    nodes[_LOWER_PAIR] = CatalogNode(
        "purple box on blue box",
        [_layer("constellation", pair)],
        ("blue_box", "purple_box"),
        _PLACING,
    )
    nodes[_STACK] = CatalogNode(
        "football on both",
        [_layer("constellations", [each.tracked for each in trials.stacks])],
        (_LOWER_PAIR, "football"),
        _PLACING,
    )
    return nodes


def _layer(name: str, hits: Sequence[bool]) -> Layer:
    return Layer(name, len(hits), sum(hits))


def _growth(stacks: Sequence[GrowingStack]) -> Iterator[BlobPanels]:
    """Yield the first stack that stands, is tracked and was always visible, in the left image."""
    whole = (each for each in stacks if len(each.views) == len(_MOMENTS))
    shown = next((each for each in whole if each.tracked and each.stands), None)
    if shown is not None:
        panels = dict(zip(_MOMENTS, shown.views, strict=True))
        yield BlobPanels("fig-7.16", "A stack of three grows (Figure 7.16)", panels, _COLORS)
