"""Positions in the announced encoding, for any characters on the line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.diagnostics.lines import lines_of
from tests.conftest import ROOT
from tests.editor.client import Client

pytest.importorskip("pygls")
from lsprotocol import types as lsp
from pygls.workspace.position_codec import PositionCodec

from cbdsl.editor.positions import Positions

ENCODINGS = {"utf-8": "utf-8", "utf-16": "utf-16-le", "utf-32": "utf-32-le"}
WIDTHS = {"utf-8": 1, "utf-16": 2, "utf-32": 4}
TEXTS = st.lists(
    st.sampled_from(["a", ":", " ", "◁", "é", "\U0001f600", "\n", "\r", "\r\n", "\u2028", "\x0c"])
).map("".join)


def units(text: str, encoding: str) -> int:
    return len(text.encode(ENCODINGS[encoding])) // WIDTHS[encoding]


def offset(text: str, position: dict[str, int], encoding: str) -> int:
    """Return the offset of a position in a text, as an editor computes it."""
    starts = [0, *(match.end() for match in re.finditer("\r\n|\r|\n", text))]
    start = starts[position["line"]]
    return next(
        end for end in range(start, len(text) + 1)
        if units(text[start:end], encoding) >= position["character"]
    )  # fmt: skip


def edited(text: str, edits: list[dict[str, Any]], encoding: str) -> str:
    """Return a text after changes, as an editor applies them."""
    spans = [
        (*(offset(text, each["range"][end], encoding) for end in ("start", "end")), each["newText"])
        for each in edits
    ]
    for start, end, new in sorted(spans, reverse=True):
        text = text[:start] + new + text[end:]
    return text


@pytest.mark.parametrize("encoding", ENCODINGS)
@given(text=TEXTS, data=st.data())
def test_positions_of_every_place_are_those_of_an_editor(
    encoding: str, text: str, data: st.DataObject
) -> None:
    positions = Positions(text, PositionCodec(encoding))
    lines = lines_of(text)
    line = data.draw(st.integers(0, len(lines) - 1))
    column = data.draw(st.integers(0, len(lines[line])))
    shown = positions.range(line, column, column).start
    place = {"line": shown.line, "character": shown.character}
    assert lines_of(text[: offset(text, place, encoding)])[line:] == [lines[line][:column]]
    assert positions.spot(shown) == (line, column)
    end = positions.whole().end
    assert offset(text, {"line": end.line, "character": end.character}, encoding) == len(text)


@given(text=TEXTS, line=st.integers(0, 99), character=st.integers(0, 99))
def test_positions_beyond_the_text_raise_nothing(text: str, line: int, character: int) -> None:
    positions = Positions(text, PositionCodec("utf-16"))
    found = positions.spot(lsp.Position(line, character))
    assert min(found) >= 0
    assert positions.range(*found, found[1] + 1).start.line >= 0


PROGRAM = """\
cbdsl: 1
kind: program
name: marks
description: "◁ \U0001f600"
robot: dexter
stage: absent
controllers:
  search: {potential: spring, reference: head.uniform, feedback: head, effector: head, x: "◁"}
  track: {potential: sprung, reference: left.hue_1, feedback: left.center, effector: head}
actions: [search, track ◁ search, search ◁ trac, search]
policy: {XX: search ◁ track ◁ search, "\U0001f600": trakc}
"""


@pytest.fixture(
    params=[["utf-8"], ["utf-16"], ["utf-32"], ["utf-8", "utf-16"], ["utf-32", "utf-8"], [], None],
    ids=str,
)
def client(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Client]:
    client = Client(tmp_path, request.param)
    yield client
    assert client.close() == 0


def test_every_answer_is_in_the_announced_encoding(client: Client, tmp_path: Path) -> None:
    encoding, path = client.capabilities["positionEncoding"], tmp_path / "marks.yaml"
    client.open(path, PROGRAM)
    diagnostics = client.diagnostics(path)
    assert len(diagnostics) >= 3
    _check_fixes(client, path, diagnostics, encoding)
    _check_names(client, path, encoding)
    _check_colors(client, path, encoding)


def _place(text: str, at: int, encoding: str) -> dict[str, int]:
    start = text.rfind("\n", 0, at) + 1
    return {"line": text.count("\n", 0, at), "character": units(text[start:at], encoding)}


def _check_fixes(client: Client, path: Path, diagnostics: Any, encoding: str) -> None:
    """Check that every quick fix replaces a misspelled name, and nothing else."""
    document = {"uri": path.as_uri()}
    whole = {"start": {"line": 0, "character": 0}, "end": {"line": 99, "character": 0}}
    params = {"textDocument": document, "range": whole, "context": {"diagnostics": []}}
    actions = client.ask("textDocument/codeAction", params)
    assert len(actions) >= 2
    for action in actions:
        (edit,) = action["edit"]["changes"][path.as_uri()]
        ends = (offset(PROGRAM, edit["range"][end], encoding) for end in ("start", "end"))
        start, end = ends
        assert PROGRAM[start:end] in ("sprung", "trac", "trakc")
        assert action["diagnostics"][0]["range"] in [each["range"] for each in diagnostics]


def _check_names(client: Client, path: Path, encoding: str) -> None:
    """Check that a name after wide characters is explained, found, completed and renamed."""
    at = PROGRAM.index("track ◁ search", PROGRAM.index("policy:")) + len("track ◁ ")
    place = {"textDocument": {"uri": path.as_uri()}, "position": _place(PROGRAM, at, encoding)}
    assert "search:" in client.ask("textDocument/hover", place)["contents"]["value"]
    whole = client.ask("textDocument/prepareRename", place)
    assert whole == {"start": place["position"], "end": _place(PROGRAM, at + 6, encoding)}
    there = client.ask("textDocument/definition", place)
    assert there["uri"] == path.as_uri()
    changes = client.ask("textDocument/rename", {**place, "newName": "look"})
    (change,) = changes["documentChanges"]
    assert edited(PROGRAM, change["edits"], encoding) == PROGRAM.replace("search", "look")
    items = client.ask("textDocument/completion", place)["items"]
    (item,) = (each for each in items if each["label"] == "track")
    assert item["textEdit"]["range"] == whole


def _check_colors(client: Client, path: Path, encoding: str) -> None:
    document = {"textDocument": {"uri": path.as_uri()}}
    data = client.ask("textDocument/semanticTokens/full", document)["data"]
    words, line, column = set(), 0, 0
    for step, start, length, *_ in zip(*[iter(data)] * 5, strict=True):
        line, column = line + step, start if step else column + start
        ends = ({"line": line, "character": c} for c in (column, column + length))
        first, last = (offset(PROGRAM, each, encoding) for each in ends)
        words.add(PROGRAM[first:last])
    assert {"search", "track", "◁", "spring"} <= words


@pytest.mark.parametrize("client", [["utf-8"]], indirect=True)
def test_places_in_other_files_are_in_the_announced_encoding(
    client: Client, tmp_path: Path
) -> None:
    """Related places in another file count a preceding wide character in the announced encoding."""
    part = (
        "{cbdsl: 1, kind: program, description: ◁◁, name: part, robot: dexter, stage: absent, "
        "parameters: {goal: head.ahead}, controllers: {turn: {potential: spring, "
        "reference: $goal, feedback: head, effector: head}}, actions: [turn], policy: {X: turn}}"
    )
    (tmp_path / "part.yaml").write_text(part, encoding="utf-8")
    path = tmp_path / "whole.yaml"
    text = (
        "cbdsl: 1\nkind: program\nname: whole\nrobot: dexter\nstage: absent\ncontrollers: {}\n"
        "use: {one: {program: part, with: {goal: right_arm.ready}}}\n"
        "actions: [one]\npolicy: {X: one}\n"
    )
    client.open(path, text)
    diagnostics = client.diagnostics(path)
    related = [each for f in diagnostics for each in f.get("relatedInformation", ())]
    uri = (tmp_path / "part.yaml").as_uri()
    starts = [r["location"]["range"]["start"] for r in related if r["location"]["uri"] == uri]
    assert starts, diagnostics
    for start in starts:
        assert part[offset(part, start, "utf-8") :].startswith("$goal")


def test_definition_elsewhere_has_an_absolute_address(tmp_path: Path) -> None:
    """Addresses are absolute even if the server runs in the folder of the documents."""
    for folder, name, text in (
        ("programs/stages", "mine", "cbdsl: 1\nkind: stage\nname: mine\nrobot: dexter\n"),
        ("programs", "marks", PROGRAM.replace("absent", "mine")),
    ):
        (tmp_path / folder).mkdir(exist_ok=True, parents=True)
        (tmp_path / folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    client = Client(tmp_path)
    path = tmp_path / "programs" / "marks.yaml"
    text = path.read_text("utf-8")
    client.open(path, text)
    for key, file in (
        ("stage: ", tmp_path / "programs/stages/mine.yaml"),
        ("robot: ", ROOT / "robots" / "dexter.yaml"),
    ):
        place = _place(text, text.index(key) + len(key) + 1, "utf-16")
        there = client.at("definition", path, place["line"], place["character"])
        assert there["uri"] == file.as_uri()
    client.close()
