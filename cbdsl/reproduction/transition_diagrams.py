"""Transition diagrams of learned policies (Figures 4.5, 4.7, 4.10, 4.11 and 4.13)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from cbdsl.reproduction.arcs import LEAST, Arc, DrawnArc, diagram_of
from cbdsl.reproduction.checks import Check, Schedule, check, schedule
from cbdsl.reproduction.diagram import Diagram
from cbdsl.reproduction.experiment import Outcome, Settings
from cbdsl.reproduction.interval import exact_interval
from cbdsl.reproduction.lesson import COARTICULATED, SEQUENTIAL, TACTILEPROBE, Lesson
from cbdsl.reproduction.quantity import Interval, Quantity, above, at_least
from cbdsl.reproduction.school import School, school

Found = tuple[Check, Mapping[Arc, float]]


@dataclass(frozen=True)
class DrawnPolicy:
    """A policy whose transition diagram the source shows.

    Attributes:
        lesson: what it is learned from.
        arcs: that the source draws.
    """

    lesson: Lesson
    arcs: tuple[DrawnArc, ...]


def _probing(search: str, sense: str) -> tuple[DrawnArc, ...]:
    """Search and sense in one action, whatever is found."""
    both = f"{search} ◁ {sense}"
    return (
        DrawnArc("XX", both, ("00",)),
        DrawnArc("XX", both, ("0-",)),
        DrawnArc("*-", both, ("*0",)),
        DrawnArc("*0", both, ("*1",)),
    )


#: By figure.
DRAWN: Mapping[str, tuple[DrawnPolicy, ...]] = {
    "fig-4.5": (
        DrawnPolicy(
            SEQUENTIAL,
            (
                DrawnArc("XX", "track", ("X0",)),
                DrawnArc("XX", "track", ("X-",)),
                DrawnArc("X-", "search", ("*X",)),
                DrawnArc("*X", "track", ("X-",)),
                DrawnArc("*X", "track", ("X0",)),
                DrawnArc("X0", "track", ("X1",)),
            ),
        ),
        DrawnPolicy(COARTICULATED, _probing("search", "track")),
    ),
    "fig-4.7": (DrawnPolicy(TACTILEPROBE, _probing("search", "touch")),),
}


def run(settings: Settings, name: str) -> Outcome:
    """Learn, run the greedy policies in held-out episodes, and look for the source's arcs."""
    plan = schedule(settings)
    quantities: list[Quantity] = []
    diagrams: list[Diagram] = []
    with school(settings) as dexter:
        for drawn in DRAWN[name]:
            dexter.expect(
                dexter.trials(drawn.lesson) * (dexter.episodes(drawn.lesson) + plan.held_out)
            )
        for drawn in DRAWN[name]:
            found = _final_diagrams(dexter, drawn.lesson, plan)
            quantities += _quantities(drawn, found)
            diagrams.append(_pooled(name, drawn.lesson, found))
    return Outcome(tuple(quantities), tuple(diagrams), _notes(plan))


def _final_diagrams(dexter: School, lesson: Lesson, plan: Schedule) -> list[Found]:
    """What each trial's greedy policy passes in held-out episodes."""
    checks = [check(dexter, learned, plan) for learned in dexter.learn(lesson)]
    return [(each, diagram_of(each.experiences)) for each in checks]


def _quantities(drawn: DrawnPolicy, found: Sequence[Found]) -> Iterator[Quantity]:
    """How many of the trials have what the source draws."""
    diagrams = [diagram for _, diagram in found]
    have_all = [all(arc.is_among(diagram) for arc in drawn.arcs) for diagram in diagrams]
    label = drawn.lesson.label
    yield _share(f"{label}: policies with all arcs", have_all, "")
    for arc in drawn.arcs:
        joined = sum(arc.is_joined(diagram) for diagram in diagrams)
        note = f"{joined} with whatever action"
        yield _share(f"{label}: {arc}", [arc.is_among(diagram) for diagram in diagrams], note)
    rewarded = [
        experience.reward > 0
        for check, _ in found
        for experience in check.experiences
        if experience.context not in drawn.lesson.hopeless
    ]
    yield Quantity(
        f"{label}: held-out episodes that the greedy policy is rewarded in",
        "%",
        "its reward is found",
        100 * sum(rewarded) / len(rewarded) if rewarded else math.nan,
        at_least(95),
        interval=_percent(sum(rewarded), len(rewarded)) if rewarded else None,
        note=f"{sum(rewarded)} of {len(rewarded)}",
    )


def _share(name: str, has: Sequence[bool], note: str) -> Quantity:
    counted = f"{sum(has)} of {len(has)} trials"
    return Quantity(
        name,
        "%",
        "drawn",
        100 * sum(has) / len(has),
        above(50),
        interval=_percent(sum(has), len(has)),
        note=f"{counted}; {note}" if note else counted,
    )


def _percent(hits: int, trials: int) -> Interval:
    low, high = exact_interval(hits, trials)
    return 100 * low, 100 * high


def _pooled(name: str, lesson: Lesson, found: Sequence[Found]) -> Diagram:
    """The episodes of all trials in one diagram."""
    arcs = diagram_of(chain.from_iterable(check.experiences for check, _ in found))
    members = next(iter(arcs)).state
    title = f"{lesson.label}: transitions of all greedy policies, above {100 * LEAST:.0f} %"
    return Diagram(f"{name}-{lesson.name}", title, "X" * len(members), arcs)


def _notes(plan: Schedule) -> tuple[str, ...]:
    return (
        f"After a trial, its greedy policy runs {plan.held_out} episodes that it did not learn "
        f"from. An arc is there if more than {100 * LEAST:.0f} % of what leaves its state takes "
        "it, and counts as reproduced if most trials have it. In the picture all trials are one.",
        "Where the superior controller has no reference, it moves nothing: then both orders of a "
        "composition do the same, and which of them a policy names there is chance.",
    )
