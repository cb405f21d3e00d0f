"""Requests, verbs and commands offer the same inputs with the same defaults."""

from __future__ import annotations

import inspect
from dataclasses import MISSING, Field
from typing import Any

import pytest
import typer

import cbdsl
import cbdsl_calibration
from cbdsl.api.requests.explored_actions import read_action
from cbdsl.api.requests.load_request import LoadRequest
from cbdsl.cli.main import build_app

#: Command of each verb, and parameters of the command with the names of their fields.
COMMANDS = {
    "load": ("run", {}),
    "learn": ("learn", {}),
    "explore": ("explore", {}),
    "explore_pairs": ("explore", {"thing": "things", "programs": "program"}),
    "calibrate": ("calibrate", {}),
}
REQUESTS: dict[str, Any] = {
    "load": LoadRequest,
    "learn": cbdsl.LearnRequest,
    "explore": cbdsl.ExploreRequest,
    "explore_pairs": cbdsl.ExplorePairsRequest,
    "calibrate": cbdsl_calibration.CalibrateRequest,
}
FUNCTIONS: dict[str, Any] = {
    "load": cbdsl.load,
    "learn": cbdsl.learn,
    "explore": cbdsl.explore,
    "explore_pairs": cbdsl.explore_pairs,
    "calibrate": cbdsl_calibration.calibrate,
}
#: Inputs that only Python has, or that the command sets.
NOT_OF_COMMANDS = {
    "number",
    "folder",
    "command",
    "uncalibrated",
    "on_episode",
    "on_action",
    "on_progress",
}
VERBS = pytest.mark.parametrize("verb", REQUESTS)


def _default(field: Field[Any]) -> object:
    if field.default_factory is not MISSING:
        return None  # an empty mapping, which is `None` in a signature and an empty list in Typer
    return field.default


@VERBS
def test_parameters_of_a_verb_are_the_fields_of_its_request(verb: str) -> None:
    fields = REQUESTS[verb].__dataclass_fields__
    parameters = inspect.signature(FUNCTIONS[verb]).parameters
    assert [*parameters] == [*fields]
    for name, parameter in parameters.items():
        required = fields[name].default is fields[name].default_factory is MISSING
        assert (parameter.default is inspect.Parameter.empty) == required, name
        assert (parameter.kind is inspect.Parameter.KEYWORD_ONLY) == fields[name].kw_only, name


@VERBS
def test_docstring_of_a_verb_describes_each_parameter(verb: str) -> None:
    text = inspect.getdoc(FUNCTIONS[verb]) or ""
    for name in inspect.signature(FUNCTIONS[verb]).parameters:
        assert f"\n    {name}: " in text, name


@VERBS
def test_options_of_a_command_have_the_defaults_of_its_request(verb: str) -> None:
    command, renamed = COMMANDS[verb]
    fields = REQUESTS[verb].__dataclass_fields__
    shared = set()
    for parameter in typer.main.get_command(build_app([command])).commands[command].params:  # type: ignore[attr-defined]
        name = renamed.get(str(parameter.name), str(parameter.name))
        if name in fields:
            shared.add(name)
            # The default backend depends on the installation; without --thing there are no pairs.
            if name not in ("backend", "things") and not parameter.required:
                assert (parameter.default or None) == (_default(fields[name]) or None), name
    assert fields.keys() - shared <= NOT_OF_COMMANDS


@VERBS
def test_fields_of_a_request_are_typed_and_described(verb: str) -> None:
    request = REQUESTS[verb]
    text = inspect.getdoc(request) or ""
    for name in request.__dataclass_fields__:
        assert f"\n    {name}: " in text, name


def test_explore_reads_loaded_programs_as_their_text() -> None:
    loaded = cbdsl.load("reachtouch", values={"arm": "left_arm", "hand": "left_hand"})
    action = read_action(loaded)
    typed = read_action(f"{loaded.program_file}:arm=left_arm,hand=left_hand")
    assert action == typed
    assert action.label == "reachtouch_left_arm_left_hand"


def test_call_of_an_exploration_names_loaded_programs_and_constants_as_values() -> None:
    from pathlib import Path

    request = cbdsl.ExploreRequest(
        ["searchtrack", cbdsl.load("searchtrack")], "exploring_basketball", Path("ball.yaml"),
        actions=4, backend="kinematic", constants={"least": 1},
    )  # fmt: skip
    assert request._call() == (
        "cbdsl.explore(['searchtrack', cbdsl.load('searchtrack', stage='table_right', values={})], "
        "'exploring_basketball', 'ball.yaml', actions=4, seed=0, backend='kinematic', "
        "constants={'least': 1})"
    )
