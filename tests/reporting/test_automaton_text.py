"""Automata of programs as data, and transitions in words."""

from __future__ import annotations

import re

import pytest

import cbdsl
from cbdsl.program.transition import Transition
from cbdsl.program.uses import used_programs
from cbdsl.reporting.automaton_text import automata, transition_text
from tests.program.test_dry_run import PROGRAMS, program_of

SURVEY = """
look       XX0000000 XX0101000      look -> fail wider than the hand, since wide is true
look       XX0000000 XX0-00000      look -> searchtrack, since wide is undefined
look       XX0000000 XX1000000      look -> succeed, since look is at rest
look       XX0000000 XX1000000 look look -> fail, since look is stuck
open       XXXXXXXXX 0XXXXXXXX      open begins
open       0XXXXXXXX 1XXXXXXXX      open -> searchtrack, since open is at rest
open       0XXXXXXXX 0XXXXXXXX
another    0XXXXXXXX 1XXXXXXXX
"""


@pytest.mark.parametrize("row", SURVEY.strip().splitlines())
def test_transition_text_names_both_steps_and_the_reason(row: str) -> None:
    action, before, after = row.split()[:3]
    stuck = tuple(row[31:35].split())
    made = Transition("survey", 0, 0.0, before, action, after, 1, 0, stuck=stuck)
    assert transition_text(automata(program_of("survey"))["survey"], made) == row[36:]


def test_transition_text_tells_a_stuck_member_from_one_that_arrived() -> None:
    known = automata(program_of("take"))["take"]
    states = "XX01XXXXXX", "reach ◁ keep", "XX11XXXXXX"
    texts = [
        transition_text(known, Transition("take", 0, 0.0, *states, 1, 0, stuck=stuck))
        for stuck in ((), ("reach",))
    ]
    assert texts == [f"keep -> touch, since reach is {word}" for word in ("at rest", "stuck")]


def test_transition_text_of_a_reward_that_ends_names_the_rewarded_member() -> None:
    made = Transition("reachtouch", 0, 0.0, "X10", "reach ◁ touch", "X11", 1, 1, ("touch",))
    text = transition_text(automata(program_of("reachtouch"))["reachtouch"], made)
    assert text == "reach ◁ touch -> the end, since touch is at rest"


@pytest.mark.parametrize("name", ["take", "let_go", "put_back"])
def test_transition_text_names_the_step_that_the_run_takes_next(name: str) -> None:
    told = {each.name: each for each in used_programs(program_of(name))}
    known = automata(program_of(name))
    made: list[Transition] = []
    cbdsl.run(name, backend="kinematic", seed=1, on_transition=made.append)
    checked = 0
    for number, each in enumerate(made):
        text = each.program in known and transition_text(known[each.program], each)
        following = next((o for o in made[number + 1 :] if o.use == each.use), None)
        if not text or following is None:
            continue
        steps = {step["action"]: step["step"] for step in known[each.program]["steps"]}
        went = re.match(r"(.*) -> (.*?)(, since|$)", text)
        to = went[2] if went else steps[each.action]
        ends = to.split()[0] in ("succeed", "fail", "the")
        assert ends or to == steps[following.action], text
        checked += 1
    assert checked > 1 and told.keys() >= known.keys()


@pytest.mark.parametrize("name", PROGRAMS)
def test_automata_of_a_shipped_program_name_steps_and_ends_alone(name: str) -> None:
    for data in automata(program_of(name)).values():
        steps = {step["step"] for step in data["steps"]}
        assert data["start"] in steps
        for step in data["steps"]:
            for each in step["exits"]:
                assert each["to"] in steps or each["to"].split()[0] in ("succeed", "fail", "end")
                assert set(each["letters"]) <= set(data["members"])
