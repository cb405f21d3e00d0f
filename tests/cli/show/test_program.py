"""Tests of ``cb show program`` and ``cb show potentials``."""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree

import pytest

from cbdsl.documents.program import ProgramDocument
from cbdsl.types.potential import POTENTIALS
from cbdsl.yaml_text.library import Library, shipped
from tests.cli.test_main import cb
from tests.program.test_dry_run import PROGRAMS

SHIPPED = Library(shipped())


def printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str
) -> str:
    assert cb(monkeypatch, "show", *arguments) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", PROGRAMS)
def test_text_fits_a_terminal_of_80_columns(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(monkeypatch, capsys, "program", name)
    assert [line for line in text.splitlines() if len(line) > 80] == []


@pytest.mark.parametrize("name", PROGRAMS)
def test_text_of_show_program_contains_the_values_of_its_json(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = re.sub(r"\s+", " ", printed(monkeypatch, capsys, "program", name))
    data = json.loads(printed(monkeypatch, capsys, "program", name, "--format", "json"))
    assert data == json.loads(printed(monkeypatch, capsys, "program", name, "--json"))
    for controller in data["controllers"]:
        for key in ("controller", "feedback", "reference", "effector", "casts"):
            assert controller[key] in text
        if controller["requires"] is not None:
            assert f" requires {controller['requires']} " in text
    for resource in data["resources"]:
        assert resource["resource"] in text
    for action in data["actions"]:
        for level in action["levels"]:
            numbers = (level["joints"], level["rows_at_most"], level["free_at_least"])
            assert f"{level['controller']} {' '.join(map(str, numbers))}" in text
        assert not action["rewarding"] or f"when {' or '.join(action['rewarding'])} comes" in text
    for key, claim in data["claims"].items():
        assert f"{key} {claim}" in text
    has_steps = bool(
        SHIPPED.read(SHIPPED.locate(ProgramDocument, name), ProgramDocument).document.steps
    )
    for step in data["automaton"]["steps"] if has_steps else ():
        assert f" {step['step']}: {step['action']} " in text
        assert all(f" {exit_['when']}: {exit_['to']} " in text for exit_ in step["exits"])
    for state, action in () if has_steps else data["policy"].items():
        assert f"{state} {action} {data['states']['decided'][state]}" in text
    decided = sum(data["states"]["decided"].values())
    assert decided + data["states"]["undecided"] == data["states"]["all"]


def test_show_program_includes_used_programs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(monkeypatch, capsys, "program", "reachtouch")
    assert "\nsearchtrack on dexter" in text
    data = json.loads(printed(monkeypatch, capsys, "program", "reachtouch", "--json"))
    (used,) = [action["uses"] for action in data["actions"] if action["uses"]]
    assert used["name"] == "searchtrack"


@pytest.mark.parametrize(
    ("notation", "start"), [("dot", "digraph "), ("mermaid", "flowchart "), ("svg", "<svg ")]
)
def test_graphs_are_printed(
    notation: str,
    start: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = printed(monkeypatch, capsys, "program", "reachtouch", "--format", notation)
    assert text.startswith(start)
    if notation == "svg":
        ElementTree.fromstring(text)


def test_every_quantity_has_its_unit(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = " ".join(printed(monkeypatch, capsys, "program", "reachtouch").split())
    for told in (
        "stereo.sat_10: position in m,",
        "right_hand.finger_forces: force x 3 in N,",
        "reference [3.14159, 0, 0] rad ",
        "gain 8 /s, speed 0.35 m/s at most, acceleration 1.5 m/s² at most",
        "gain 4 /s, speed 0.3 rad/s at most",  # speed of the joints that generate the forces
    ):
        assert told in text


def test_unknown_format_is_reported_with_the_known_ones(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "program", "reach", "--format", "xml") == 2
    told = "cb: unknown format 'xml' (known: text, json, dot, mermaid, svg)\n"
    assert capsys.readouterr().err == told


def test_show_potentials_lists_every_potential(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    table = printed(monkeypatch, capsys, "potentials")
    rows = json.loads(printed(monkeypatch, capsys, "potentials", "--json"))
    assert [row["potential"] for row in rows] == list(POTENTIALS)
    for row, potential in zip(rows, POTENTIALS.values(), strict=True):
        assert row["accepts"] == sorted(potential.accepts)
        assert (row["symbol"], row["defined by"]) == (potential.symbol, potential.equation)
        assert all(str(row[key]) in table for key in ("potential", "symbol", "defined by"))
        assert row["navigation"]["for"] == potential.navigation.domain
        assert potential.navigation.domain in table


@pytest.mark.parametrize(
    ("name", "success", "failure"),
    [
        ("put_down", "in state XXX1", "in state --XX"),
        ("reachtouch", "when touch is rewarded", "by no state"),
        ("posture", "when its last action comes to rest", "by no state"),
    ],
)
def test_show_program_states_success_and_failure_once(
    name: str,
    success: str,
    failure: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = printed(monkeypatch, capsys, "program", name).split("\n\n")[0]
    assert re.findall(r"^  success +(.*)$", text, re.MULTILINE) == [success]
    assert re.findall(r"^  failure +(.*)$", text, re.MULTILINE) == [failure]
