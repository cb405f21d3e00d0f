"""Series: they name shipped documents, and ``cb learn`` can run them as well."""

from __future__ import annotations

import shlex

import pytest
import typer

from cbdsl.api.shipped import shipped_file
from cbdsl.checking.program import check_program
from cbdsl.cli.learn import learn
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.yaml_text.library import Library, shipped
from cbdsl_reproduction.chapter_4.transition_diagrams import DRAWN, DrawnPolicy

POLICIES = [
    pytest.param(each, id=each.series.name) for policies in DRAWN.values() for each in policies
]
LIBRARY = Library(shipped())


@pytest.mark.parametrize("drawn", POLICIES)
def test_drawn_states_and_actions_exist_in_the_program(drawn: DrawnPolicy) -> None:
    series = drawn.series
    program = check_program(shipped_file(LIBRARY, ProgramDocument, series.program), {}, LIBRARY)
    stage = LIBRARY.read(shipped_file(LIBRARY, StageDocument, series.stage), StageDocument).document
    actions = {action.name for action in series.actions(program)}
    for arc in drawn.arcs:
        assert arc.action in actions
        assert {len(pattern) for pattern in (arc.state, *arc.next_states)} == {len(program.members)}
        assert arc.context is None or arc.context in stage.contexts
    assert series.hopeless < set(stage.contexts)


@pytest.mark.parametrize("drawn", POLICIES)
def test_cb_learn_understands_the_command(drawn: DrawnPolicy) -> None:
    series = drawn.series
    app = typer.Typer()
    app.command()(learn)
    cb, name, *words = shlex.split(series.command(3, trials=2, episodes=7, backend="kinematic"))
    assert (cb, name) == ("cb", "learn")
    given = typer.main.get_command(app).make_context(name, words).params
    assert {key: given[key] for key in ("program", "stage", "sequential")} == {
        key: getattr(series, key) for key in ("program", "stage", "sequential")
    }
    assert (given["density"] or "kernel") == series.density
    assert {key: given[key] for key in ("seed", "trials", "episodes", "backend")} == {
        "seed": 3,
        "trials": 2,
        "episodes": 7,
        "backend": "kinematic",
    }
