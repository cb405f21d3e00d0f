"""Transition diagrams of learned policies (Figures 4.5, 4.7, 4.10, 4.11, 4.13 and 7.2)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from cbdsl.api.drawing import ABOVE
from cbdsl.api.program import ANY, SUBJECT_TO, CheckedProgram, matches
from cbdsl.api.trials import Trial
from cbdsl_reproduction.chapter_4.arcs import ActionArc, DrawnArc, diagram_of
from cbdsl_reproduction.chapter_4.checks import Check, Schedule, checks, schedule
from cbdsl_reproduction.chapter_4.learned_in import (
    LearnedInClaims,
    learned_in_claims,
    learned_in_quantities,
)
from cbdsl_reproduction.chapter_4.worth import (
    AS_GOOD,
    shares_of,
    worth_claims,
    worth_quantities,
)
from cbdsl_reproduction.claim import Claim, Claims
from cbdsl_reproduction.diagram import Diagram, graph_of
from cbdsl_reproduction.experiment import Result, RunSettings
from cbdsl_reproduction.percentage import clustered_percentage, percentage
from cbdsl_reproduction.quantity import Quantity
from cbdsl_reproduction.region import above, at_least, at_most, in_hindsight
from cbdsl_reproduction.series import (
    BIMANUALTOUCH,
    COARTICULATED,
    PICKANDPLACE,
    REACHTOUCH,
    SEQUENTIAL,
    TACTILEPROBE,
    VISUALINSPECT,
    Series,
)
from cbdsl_reproduction.trial_runner import TrialRunner, trial_runner

#: Worth of actions, by state and action.
Worth = Mapping[str, Mapping[str, float]]

_REACH, _INSPECT, _BRING, _PUT = (
    "reach ◁ touch",
    "localizability ◁ track",
    "conditionedhold ◁ touch",
    "transport ◁ place",
)


@dataclass(frozen=True)
class DrawnPolicy:
    """Policy whose transition diagram the source shows.

    Attributes:
        place: Section and figure of the source.
        series: Series of trials in which it is learned.
        arcs: Arcs that the source draws.
        learned_in: Number of episodes within which it is learned in the source, if the source
            shows no curve.
    """

    place: str
    series: Series
    arcs: tuple[DrawnArc, ...]
    learned_in: int | None = None

    def claims(self) -> Iterator[Claim]:
        """Yield all claims about the policy."""
        yield self.drawn("policies with all arcs")
        yield from (self.drawn(str(arc)) for arc in self.arcs)
        yield from self.worth().values()
        yield self.rewarded()
        yield from self.learned() or ()

    def drawn(self, element: str) -> Claim:
        """Return the claim about the share of trials that have an element of the diagram."""
        name = f"{self.series.label}: {element}"
        return Claim(self.place, name, "%", "drawn", in_hindsight(above(50)))

    def worth(self) -> dict[tuple[str, str], Claim]:
        """Return the claims about the worth of the drawn choices, by state and action."""
        return worth_claims(self.place, self.series, self.choices())

    def rewarded(self) -> Claim:
        """Return the claim about the share of rewarded episodes."""
        name = f"{self.series.label}: held-out episodes that the greedy policy is rewarded in"
        return Claim(self.place, name, "%", "its reward is found", at_least(95))

    def learned(self) -> LearnedInClaims | None:
        """Return the claims about the episodes of learning, if the source shows no curve."""
        if self.learned_in is None:
            return None
        report, region = f"within {self.learned_in}", at_most(self.learned_in)
        return learned_in_claims(self.place, self.series, report, region)

    def choices(self) -> list[tuple[str, str]]:
        """Return the single states that the source's arcs leave, and the actions chosen there."""
        single = [(arc.state, arc.action) for arc in self.arcs if ANY not in arc.state]
        return list(dict.fromkeys(single))


@dataclass(frozen=True)
class Examined:
    """Trial at its end, and the checks of its policies during learning."""

    trial: Trial
    checks: tuple[Check, ...]


def _probing(search: str, sense: str) -> tuple[DrawnArc, ...]:
    """Return the arcs of searching and sensing in one action, for all outcomes."""
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
            "Section 4.2.1, Figure 4.5",
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
        DrawnPolicy("Section 4.2.1, Figure 4.5", COARTICULATED, _probing("search", "track")),
    ),
    "fig-4.7": (
        DrawnPolicy(
            "Section 4.2.2, Figure 4.7", TACTILEPROBE, _probing("search", "touch"), learned_in=25
        ),
    ),
    "fig-4.10": (
        DrawnPolicy(
            "Section 4.3.1, Figure 4.10",
            REACHTOUCH,
            (
                DrawnArc("XXX", _REACH, ("X0-",), "presented"),
                DrawnArc("XXX", _REACH, ("X--",), "delivered"),
                DrawnArc("X--", "searchtrack", ("0XX", "1XX")),
                DrawnArc("1XX", _REACH, ("X0-",)),
                DrawnArc("X0-", _REACH, ("X*0", "X11"), "presented"),
                DrawnArc("X**", _REACH, ("X11",), "presented"),
                DrawnArc("X0-", _REACH, ("X1-",), "absent"),
            ),
            learned_in=25,
        ),
    ),
    "fig-4.11": (
        DrawnPolicy(
            "Section 4.3.2, Figure 4.11",
            VISUALINSPECT,
            (
                DrawnArc("XXX", "track", ("XX0",), "facing"),
                DrawnArc("XX0", "track", ("XX1",), "facing"),
                DrawnArc("XXX", "track", ("XX-",), "hidden"),
                DrawnArc("XX-", "reachtouch", ("0XX", "1XX"), "hidden"),
                DrawnArc("1XX", _INSPECT, ("X0-",), "hidden"),
                DrawnArc("X0-", _INSPECT, ("X00",), "hidden"),
                DrawnArc("X00", _INSPECT, ("X01",), "hidden"),
            ),
            learned_in=50,
        ),
    ),
    "fig-4.13": (
        DrawnPolicy(
            "Section 4.3.3, Figure 4.13",
            BIMANUALTOUCH,
            (
                DrawnArc("XXX", "reachtouch", ("0XX", "1XX")),
                DrawnArc("1XX", _BRING, ("X0-",)),
                DrawnArc("X0-", _BRING, ("X00",)),
                DrawnArc("X00", _BRING, ("X10",)),
                DrawnArc("X10", _BRING, ("X11",)),
            ),
            learned_in=25,
        ),
    ),
    "fig-7.2": (
        DrawnPolicy(
            "Section 7.1.1, Figure 7.2",
            PICKANDPLACE,
            (
                DrawnArc("XXX", "reachtouch", ("0XX", "1XX")),
                DrawnArc("1XX", _PUT, ("X0-",)),
                DrawnArc("X0-", _PUT, ("X00", "X01")),
                DrawnArc("X00", _PUT, ("X01",)),
            ),
            learned_in=30,
        ),
    ),
}
CLAIMS: Claims = {
    figure: tuple(claim for drawn in policies for claim in drawn.claims())
    for figure, policies in DRAWN.items()
}


def run(settings: RunSettings, name: str) -> Result:
    """Learn, run the greedy policies in held-out episodes, and search for the source's arcs."""
    plan = schedule(settings)
    quantities: list[Quantity] = []
    diagrams: list[Diagram] = []
    with trial_runner(settings) as dexter:
        policies = gather(dexter, settings, name)
        programs = [dexter.program(series) for series in series_of(name)]
    for drawn, program, examined in zip(DRAWN[name], programs, policies, strict=True):
        trials, checked = [each.trial for each in examined], [each.checks for each in examined]
        last = [each[-1] for each in checked]
        quantities += _quantities(drawn, last, shares_of(trials))
        quantities += worth_quantities(drawn.worth(), trials, settings.seed)
        quantities.append(_rewarded(drawn, last))
        learned = drawn.learned()
        if learned is not None:
            quantities += learned_in_quantities(drawn.series, checked, learned, settings.seed)
        diagrams.append(_typical(name, drawn.series, program, last))
    return Result(tuple(quantities), tuple(diagrams), _notes(plan))


def series_of(name: str) -> tuple[Series, ...]:
    """Return the series of trials."""
    return tuple(drawn.series for drawn in DRAWN[name])


def gather(dexter: TrialRunner, settings: RunSettings, name: str) -> list[list[Examined]]:
    """Run all episodes of each trial of each policy that the source draws."""
    plan = schedule(settings)
    for drawn in DRAWN[name]:
        episodes = dexter.episodes(drawn.series)
        each = episodes + plan.held_out * len(_when(drawn, episodes, plan))
        dexter.expect(len(dexter.numbers(drawn.series)) * each)
    return [_examined(dexter, drawn, plan) for drawn in DRAWN[name]]


def _when(drawn: DrawnPolicy, episodes: int, plan: Schedule) -> Sequence[int]:
    """Return the numbers of episodes after which to check; a diagram needs only the last one."""
    return [episodes] if drawn.learned_in is None else plan.after(episodes)


def _examined(dexter: TrialRunner, drawn: DrawnPolicy, plan: Schedule) -> list[Examined]:
    """Return each trial with its checks."""
    when = _when(drawn, dexter.episodes(drawn.series), plan)
    return [
        Examined(learned.trial, checks(dexter, learned, plan, when))
        for learned in dexter.learn(drawn.series)
    ]


def _quantities(drawn: DrawnPolicy, last: Sequence[Check], worth: Worth) -> Iterator[Quantity]:
    """Yield the shares of trials that have the arcs of the source."""
    columns = [(arc, orders_alike(arc, worth), _looks(arc, last)) for arc in drawn.arcs]
    whole = [
        all(
            _has(arc, look.arcs, alike)
            for (arc, alike, _), look in zip(columns, row, strict=True)
            if look.arcs
        )
        for row in zip(*(looks for _, _, looks in columns), strict=True)
    ]
    yield _drawn(drawn.drawn("policies with all arcs"), whole)
    for arc, alike, looks in columns:
        met = [look.arcs for look in looks if look.is_met]
        joined = sum(arc.is_joined(arcs) for arcs in met)
        ordered = sum(arc.is_among(arcs) for arcs in met)
        note = f"{ordered} in the order drawn; " if alike else ""
        note += f"{joined} with any action"
        yield _drawn(drawn.drawn(str(arc)), [_has(arc, arcs, alike) for arcs in met], note)


def orders_alike(arc: DrawnArc, worth: Worth) -> bool:
    """Return whether the action of an arc is worth as much with its two parts reversed.

    If so, the order that a policy names is random. The condition must hold in all states that the
    arc may leave and in which both orders were chosen often enough.

    Args:
        arc: Arc that the source draws.
        worth: Worth of actions by state, on any scale.
    """
    turned = SUBJECT_TO.join(reversed(arc.action.split(SUBJECT_TO)))
    both = [
        (actions[turned], actions[arc.action])
        for state, actions in worth.items()
        if matches(arc.state, state) and turned != arc.action and {turned, arc.action} <= {*actions}
    ]
    return bool(both) and all(100 * other >= AS_GOOD * own for other, own in both)


def _has(arc: DrawnArc, arcs: Iterable[ActionArc], alike: bool) -> bool:
    """Return whether a diagram has an arc, in either order if both are worth the same."""
    return arc.is_turned_among(arcs) if alike else arc.is_among(arcs)


class _Look(NamedTuple):
    """Held-out episodes of one trial that are relevant to an arc.

    Attributes:
        arcs: Diagram of the episodes in the arc's context; empty if the context did not occur.
        is_met: True if they leave a state that the arc leaves; else they carry no evidence.
    """

    arcs: Mapping[ActionArc, float]
    is_met: bool


def _looks(arc: DrawnArc, last: Sequence[Check]) -> list[_Look]:
    looks = []
    for check in last:
        inside = [each for each in check.experiences if arc.context in (None, each.context)]
        left = (transition.state for each in inside for transition in each.transitions)
        looks.append(_Look(diagram_of(inside), any(matches(arc.state, state) for state in left)))
    return looks


def _rewarded(drawn: DrawnPolicy, last: Sequence[Check]) -> Quantity:
    hopeless = drawn.series.hopeless
    rewarded = [
        [each.reward > 0 for each in check.experiences if each.context not in hopeless]
        for check in last
    ]
    hits, sizes = [sum(own) for own in rewarded], [len(own) for own in rewarded]
    # Episodes of one policy are not independent.
    return clustered_percentage(drawn.rewarded(), hits, sizes)


def _drawn(claim: Claim, has: Sequence[bool], note: str = "") -> Quantity:
    """Return the percentage of trials that have an element that the source draws."""
    return percentage(claim, sum(has), len(has), of="trials", note=note)


def _typical(name: str, series: Series, program: CheckedProgram, last: Sequence[Check]) -> Diagram:
    """Return the diagram of the trial whose arcs have the most in common with all trials.

    Contexts without possible reward are excluded: there, a policy cycles until its transitions are
    used up, which outweighs its behaviour in the other contexts.
    """
    hopeful = [
        [each for each in check.experiences if each.context not in series.hopeless]
        or list(check.experiences)
        for check in last
    ]
    diagrams = [diagram_of(experiences) for experiences in hopeful]
    likeness = [sum(_likeness(each, other) for other in diagrams) for each in diagrams]
    trial = likeness.index(max(likeness))
    graph = graph_of(f"{series.name}_{trial}", program, hopeful[trial])
    title = f"{series.label}: greedy policy of trial {trial}, arcs above {100 * ABOVE:.0f} %"
    left_out = "".join(f", without the context {context}" for context in sorted(series.hopeless))
    return Diagram(f"{name}-{series.name}", title + left_out, graph)


def _likeness(one: Mapping[ActionArc, float], other: Mapping[ActionArc, float]) -> float:
    """Return the number of common arcs divided by the number of all arcs of both diagrams."""
    # This is the Jaccard index of both sets of arcs.
    return len(one.keys() & other.keys()) / len(one.keys() | other.keys())


def _notes(plan: Schedule) -> tuple[str, ...]:
    return (
        f"After a trial, its greedy policy runs {plan.held_out} episodes that it did not learn "
        f"from. An arc exists if more than {100 * ABOVE:.0f} % of the transitions from its state "
        "take it. It counts as reproduced if most trials have it, among the trials whose episodes "
        "leave its state; where a context of the stage is named, only episodes in it count. All "
        "arcs count for all trials, except for arcs whose context did not occur. The picture shows "
        "the trial whose arcs have the most in common with those of the others.",
        "Where the superior controller has no reference, it moves nothing, and an action that is "
        "left after its first tick, as all are in the state of an episode's beginning, has hardly "
        "moved anything: then both orders of a composition earn the same, and which of them a "
        f"policy names is chance. So where the other order is worth {AS_GOOD} % of the drawn one "
        "or more, by all trials together, either counts, and the note says how many trials have "
        "the drawn one. This rule, and that states have to be met, were set when the numbers were "
        "known.",
        "Value of an action: the transitions of all trials together form a model. Value "
        "iteration on it gives the discounted reward of each action if all later ones are "
        "optimal. Where others are worth as much as the source's, which of them a trial learns "
        "is chance. The interval is that of trials drawn anew; fewer than five trials have no "
        "median.",
    )
