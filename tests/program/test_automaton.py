"""Automata of programs: their tables decide states as their exits do."""

from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st

from cbdsl.program.automaton import Automaton, Exit, ProgramStep, To, of_tables, without
from cbdsl.program.exit_list import with_short_exits
from cbdsl.program.policy_table import PolicyTable
from cbdsl.types.state import LETTERS, matches

MEMBERS = ("a", "b", "c", "d")
BOX_LETTERS = st.sampled_from([LETTERS, "-", "0", "1", "s", "1s", "-0", "-1", "01s"])


@st.composite
def automata(draw: st.DrawFn) -> Automaton:
    """Automata of steps with different members, also with one step's members within another's."""
    kinds = st.sets(st.sampled_from(MEMBERS), min_size=1).map(lambda s: tuple(sorted(s)))
    members = draw(st.lists(kinds, min_size=1, max_size=4, unique=True))
    names = [" ◁ ".join(own) for own in members]
    ends = [To(end="success"), To(end="failure"), To(end="failure", reason="why"), To(end="end")]
    targets = st.sampled_from([*map(To, names), *ends])
    steps = {}
    for name, own in zip(names, members, strict=True):
        boxes = st.lists(st.tuples(*[BOX_LETTERS] * len(own)), min_size=1, max_size=2).map(tuple)
        exits = list(map(arriving, draw(st.lists(st.builds(Exit, boxes, targets), max_size=4))))
        rest = draw(st.sampled_from([To(name), To(end="end")]))
        steps[name] = ProgramStep(name, name, own, (LETTERS,) * len(own), tuple(exits), rest)
    return Automaton(steps, names[0], MEMBERS)


def arriving(exit_: Exit) -> Exit:
    """Ask a success for arrival, as a run does for an explicit rest."""
    if exit_.to.end != "success":
        return exit_
    boxes = (tuple(x if x == LETTERS else x.replace("1s", "1") for x in b) for b in exit_.boxes)
    return exit_._replace(boxes=tuple(boxes))


def detailed(members: tuple[str, ...], letters: tuple[str, ...]) -> str:
    own = dict(zip(members, letters, strict=True))
    return "".join(own.get(member, "X") for member in MEMBERS).replace("1", "a")


def decide(automaton: Automaton, state: str) -> To:
    """Decide a state as a run does: success, then failure in order, then the policy."""
    tables = automaton.tables()
    if any(matches(pattern, state) for pattern in tables.success):
        return To(end="success")
    for pattern, reason in tables.failure.items():
        if matches(pattern, state):
            return To(end="failure", reason=reason)
    action = PolicyTable(tables.policy).find(state)
    return To(end="end") if action is None else To(action)


@given(automata())
def test_tables_of_random_automata_decide_each_state_like_the_exits(automaton: Automaton) -> None:
    assert decide(automaton, "XXXX") == To(automaton.start)
    for step in automaton.steps.values():
        for letters in itertools.product(LETTERS, repeat=len(step.members)):
            assert decide(automaton, detailed(step.members, letters)) == step.decide(letters)


@given(automata())
def test_automaton_of_its_tables_decides_like_the_automaton(automaton: Automaton) -> None:
    active = {step.name: step.members for step in automaton.steps.values()}
    again = of_tables(automaton.tables(), MEMBERS, active, dict.fromkeys(MEMBERS, LETTERS))
    assert again is not None and again.start == automaton.start
    for step in again.steps.values():
        before = automaton.steps[step.name]
        for letters in itertools.product(LETTERS, repeat=len(step.members)):
            assert step.decide(letters) == before.decide(letters)


@given(automata(), st.sampled_from([LETTERS, "01"]))
def test_short_exits_of_a_step_decide_its_values_like_the_step(
    automaton: Automaton, letters: str
) -> None:
    for step in automaton.steps.values():
        given_step = step._replace(values=(letters, *step.values[1:]))
        short = with_short_exits(given_step)
        assert short.rest == To(step.name)
        for values in itertools.product(*given_step.values):
            assert short.decide(values) == step.decide(values)


@given(automata())
def test_targets_of_a_step_are_those_of_all_its_values(automaton: Automaton) -> None:
    for step in automaton.steps.values():
        expected = {step.decide(values) for values in itertools.product(*step.values)}
        assert {to for to, _ in step.targets} == expected
        for to, box in step.targets:
            assert all(step.decide(values) == to for values in itertools.product(*box))


@given(automata())
def test_paths_lead_to_the_steps_that_an_explicit_search_reaches(automaton: Automaton) -> None:
    # Search over states, by the tables that run, instead of over boxes of values.
    active = {step.name: step.members for step in automaton.steps.values()}
    reached, waiting = set[str](), [automaton.start]
    while waiting:
        name = waiting.pop()
        if name in reached:
            continue
        reached.add(name)
        for letters in itertools.product(LETTERS, repeat=len(active[name])):
            to = decide(automaton, detailed(active[name], letters))
            waiting += [to.step] if to.step else []
    paths = automaton.paths(automaton.targets())
    assert paths.keys() == reached
    for name, path in paths.items():
        assert path[0] == automaton.start and path[-1] == name
        for before, after in itertools.pairwise(path):
            assert after in {to.step for to, _ in automaton.steps[before].targets}


@given(st.tuples(BOX_LETTERS, BOX_LETTERS), st.tuples(BOX_LETTERS, BOX_LETTERS))
def test_without_returns_the_values_outside_of_a_box(
    box: tuple[str, ...], other: tuple[str, ...]
) -> None:
    outside = [values for part in without(box, other) for values in itertools.product(*part)]
    expected = set(itertools.product(*box)) - set(itertools.product(*other))
    assert sorted(outside) == sorted(expected)
