"""``cb show policy``: learned and written policies, in every format, and mistakes."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from cbdsl.documents.policy import PolicyDocument
from cbdsl.reporting.drawing.policy_transitions import policy_transitions
from cbdsl.reporting.text.policy_text import policy_text
from cbdsl.yaml_text.writer import write
from tests.cli.test_main import cb
from tests.reporting.drawing.policies import learned

#: Two of three episodes reach directly; the third searches again after it loses the object.
WALKS = [
    [("reach", "X0"), ("reach", "X1")],
    [("reach", "X0"), ("reach", "X1")],
    [("searchtrack", "0X"), ("reach", "X-"), ("searchtrack", "0X"), ("reach", "X1")],
]


@pytest.fixture
def policy() -> PolicyDocument:
    return learned(WALKS)


@pytest.fixture
def file(policy: PolicyDocument, tmp_path: Path) -> Path:
    file = tmp_path / "walked.yaml"
    write(policy, file)
    return file


def printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str | Path
) -> str:
    assert cb(monkeypatch, "show", "policy", *map(str, arguments)) == 0
    return capsys.readouterr().out


def test_text_has_each_state_with_its_numbers(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(monkeypatch, capsys, file)
    rows = [line.split() for line in text.splitlines()]
    assert ["XX", "reach", "0.500", "2", "3"] in rows
    assert ["X1", "3", "3"] in rows
    assert "  └ 100 % X0  reach\n    └ 100 % X1  rewarded 100 %\n" in text
    assert all(len(line) <= 80 for line in text.splitlines())


def test_states_of_a_learned_policy_are_printed_with_names_of_members(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(monkeypatch, capsys, file)
    printed_states = text.partition("\nStates in words\n")[2].partition("\n\n")[0].splitlines()
    assert printed_states[0] == "  XX  nothing is active"
    assert set(printed_states[1:]) == {
        "  X0  reach is moving",
        "  X1  reach is at rest",
        "  X-  reach is undefined",
        "  0X  searchtrack is moving",  # its program is nowhere
    }


def test_states_name_programs_and_conditions_by_their_own_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(monkeypatch, capsys, "programs/reachtouch.yaml")
    printed_states = text.partition("\nStates in words\n")[2]
    assert re.search(r"^  \S+  searchtrack succeeded$", printed_states, re.MULTILINE)
    members = ("wide", "carry")
    policy = PolicyDocument(
        cbdsl=1, kind="policy", name="p", program="p", predicates=members, policy={"1*": "carry"}
    )
    words = policy_text(policy, policy_transitions(policy), {"wide": "condition"})
    assert "  1*  wide is true\n" in words


def test_json_of_a_policy_holds_all_counts(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    data = json.loads(printed(monkeypatch, capsys, file, "--json"))
    assert data == json.loads(printed(monkeypatch, capsys, file, "--format", "json"))
    states = {each["state"]: each for each in data["states"]}
    assert (states["XX"]["action"], states["XX"]["started"]) == ("reach", 3)
    assert (states["X1"]["action"], states["X1"]["ended"]) == (None, 3)
    assert states["0X"]["after"] == {"X-": 0.5, "X1": 0.5}


def test_above_omits_rare_arcs_and_all_draws_every_state(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def arcs(*options: str) -> set[tuple[str, str]]:
        data = json.loads(printed(monkeypatch, capsys, file, "--json", *options))
        return {(arc["source"], arc["target"]) for arc in data["arcs"]}

    assert arcs() == {("XX", "X0"), ("X0", "X1")}
    assert arcs("--all") - arcs() == {("0X", "X-"), ("0X", "X1"), ("X-", "0X")}
    assert arcs("--all", "--above", "0.5") == arcs() | {("X-", "0X")}
    assert arcs("--above", "1") == set()


@pytest.mark.parametrize(
    ("notation", "start"), [("dot", "digraph "), ("mermaid", "flowchart "), ("svg", "<svg ")]
)
def test_diagrams_are_printed(
    notation: str,
    start: str,
    file: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = printed(monkeypatch, capsys, file, "--format", notation)
    assert text.startswith(start)
    if notation == "svg":
        ElementTree.fromstring(text)


def test_show_policy_of_a_program_prints_its_written_policy(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    data = json.loads(printed(monkeypatch, capsys, "programs/reachtouch.yaml", "--json"))
    program = json.loads(_program(monkeypatch, capsys))
    assert {each["state"]: each["action"] for each in data["states"]} == program["policy"]
    drawing = printed(monkeypatch, capsys, "programs/reachtouch.yaml", "--format", "svg")
    assert "A double frame is a program's: searchtrack." in drawing


def _program(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> str:
    assert cb(monkeypatch, "show", "program", "programs/reachtouch.yaml", "--json") == 0
    return capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code", "named"),
    [
        (["nonesuch"], 2, "unknown policy 'nonesuch'"),
        (["robots/dexter.yaml"], 1, "CB201"),
        (["nonesuch.yaml"], 1, "CB101"),
        (["programs/reach.yaml", "--above", "2"], 2, "--above"),
        (["programs/reach.yaml", "--above", "nan"], 2, "--above"),
        (["programs/reach.yaml", "--format", "svgg"], 2, "did you mean 'svg'? (known: text, json"),
    ],
)
def test_show_policy_with_wrong_arguments_prints_one_message(
    arguments: list[str],
    code: int,
    named: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert cb(monkeypatch, "show", "policy", *arguments) == code
    out, err = capsys.readouterr()
    assert named in out + err
    assert "Traceback" not in err and "internal error" not in err


@pytest.mark.parametrize("state", ["X", "XXX", "X?"])
def test_state_without_a_letter_for_each_member_is_reported(
    state: str,
    policy: PolicyDocument,
    file: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write(policy.model_copy(update={"policy": {**policy.policy, state: "reach"}}), file)
    for command in (["show", "policy"], ["report"]):
        assert cb(monkeypatch, *command, str(file)) == 2
        assert f"'{state}' is not a state of searchtrack, reach" in capsys.readouterr().err
