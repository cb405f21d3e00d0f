"""Help of commands with groups of options."""

from __future__ import annotations

import re
from itertools import pairwise

import pytest
from typer.testing import CliRunner

from cbdsl.cli.main import build_app


@pytest.mark.parametrize("command", ["learn", "run"])
def test_help_lists_each_option_once_below_its_group(command: str) -> None:
    shown = CliRunner().invoke(build_app([command]), [command, "--help"]).output
    places = {name: shown.index(f"\n{name}:") for name in re.findall(r"(?m)^(\w[\w ]*):$", shown)}
    assert [*places][:2] == ["Arguments", "Options"]
    assert {"Live options"} < {*places}
    options = re.findall(r"(?m)^  (--[\w-]+)", shown)
    assert len(options) == len({*options})
    sections = [shown[a:b] for a, b in pairwise([*places.values(), len(shown)])]
    (live,) = [each for each in sections if each.startswith("\nLive options:")]
    assert live.startswith("\nLive options:\n  --live ") and "--seed" not in live


def test_help_of_learn_has_a_section_for_the_constants_of_the_learner() -> None:
    shown = CliRunner().invoke(build_app(["learn"]), ["learn", "--help"]).output
    constants = shown.partition("Constants of accommodate:\n")[2].partition("\n\n")[0]
    assert re.findall(r"(?m)^  --(\w+)", constants)[:3] == ["gamma", "alpha", "epsilon"]
