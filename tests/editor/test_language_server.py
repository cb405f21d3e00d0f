"""The language server over its streams, with texts that are being typed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.editor.client import Client

pytest.importorskip("pygls")

# As a program of one robot.
TEXT = (
    (ROOT / "programs" / "searchtrack.yaml")
    .read_text("utf-8")
    .replace("roles: {eyes: stereo heading}", "robot: dexter")
    .replace("stages: [over_bench]\n", "")
    .replace("$eyes", "head")
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("own")


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[Client]:
    client = Client(folder)
    yield client
    assert client.close() == 0


@pytest.fixture
def path(folder: Path, client: Client) -> Path:
    path = folder / "searchtrack.yaml"
    client.open(path, TEXT)
    return path


def place(text: str, mark: str) -> tuple[int, int]:
    """Return line and column after a mark."""
    before = text[: text.index(mark) + len(mark)]
    return before.count("\n"), len(before) - before.rfind("\n") - 1


def test_server_announces_its_capabilities(client: Client) -> None:
    assert {"completionProvider", "hoverProvider", "definitionProvider", "codeActionProvider"} <= (
        client.capabilities.keys()
    )


def test_diagnostics_follow_the_edits_of_a_document(client: Client, path: Path) -> None:
    assert client.diagnostics(path) == []
    client.change(path, TEXT.replace("potential: spring", "potential: sprung", 1))
    (diagnostic,) = client.diagnostics(path)
    line, column = place(TEXT, "potential: ")
    assert diagnostic["code"].startswith("CB") and diagnostic["severity"] == 1
    assert diagnostic["range"]["start"] == {"line": line, "character": column}
    assert "spring" in diagnostic["message"]
    client.change(path, TEXT)
    assert client.diagnostics(path) == []


def test_a_misspelled_name_can_be_corrected(client: Client, path: Path) -> None:
    client.change(path, TEXT.replace("potential: spring", "potential: sprung", 1))
    (diagnostic,) = client.diagnostics(path)
    params = {
        "textDocument": {"uri": path.as_uri()},
        "range": diagnostic["range"],
        "context": {"diagnostics": []},
    }
    (action,) = client.ask("textDocument/codeAction", params)
    (edit,) = action["edit"]["changes"][path.as_uri()]
    assert edit == {"range": diagnostic["range"], "newText": "spring"}


def test_completion_proposes_names_of_the_expected_kind(client: Client, path: Path) -> None:
    def labels(mark: str) -> set[str]:
        return {
            each["label"] for each in client.at("completion", path, *place(TEXT, mark))["items"]
        }

    assert {"spring", "range", "manipulability"} <= labels("potential: ")
    assert "head" in labels("effector: ") and "spring" not in labels("effector: ")
    assert {"search", "track"} <= labels("actions: [")
    assert "dexter" in labels("robot: ")


def test_a_resource_reports_its_type(client: Client, path: Path) -> None:
    shown = client.at("hover", path, *place(TEXT, "effector: "))["contents"]["value"]
    assert "configuration" in shown and "rad" in shown


def test_definition_of_a_name_is_its_declaration(client: Client, path: Path) -> None:
    there = client.at("definition", path, *place(TEXT, "actions: ["))
    assert there["uri"] == path.as_uri()
    line = there["range"]["start"]["line"]
    assert TEXT.splitlines()[line].strip().startswith("search:")
    robot = client.at("definition", path, *place(TEXT, "robot: "))
    assert robot["uri"].endswith("robots/dexter.yaml")


@pytest.mark.parametrize(
    "text", ["", "{", "kind: program\ncontrollers: {a: [", "\ud83d\ude00: x", "\x00"]
)
def test_server_survives_unfinished_and_invalid_text(client: Client, path: Path, text: str) -> None:
    client.change(path, text)
    client.diagnostics(path)
    for method in ("completion", "hover", "definition"):
        client.at(method, path, 1, 30)
    client.change(path, TEXT)
    assert client.diagnostics(path) == []


def test_server_survives_every_prefix_of_a_program(client: Client, path: Path) -> None:
    for end in range(0, len(TEXT), 97):
        client.change(path, TEXT[:end])
        lines = TEXT[:end].split("\n")
        client.at("completion", path, len(lines) - 1, len(lines[-1]))
    client.change(path, TEXT)
    assert client.diagnostics(path) == []


def test_a_completion_replaces_all_of_a_name_with_dots(client: Client, path: Path) -> None:
    text = TEXT.replace("effector: head", "effector: right_arm.pos", 1)
    client.change(path, text)
    line, column = place(text, "right_arm.po")
    items = client.at("completion", path, line, column)["items"]
    (item,) = [each for each in items if each["label"] == "right_arm.position"]
    edited = item["textEdit"]["range"]
    assert (edited["start"]["character"], edited["end"]["character"]) == (column - 12, column + 1)


def test_columns_count_utf_16_code_units(client: Client, path: Path) -> None:
    """Columns count UTF-16 code units, two for a character beyond the basic plane."""
    text = TEXT.replace("effector: head", 'effector: "\U0001f600head"', 1)
    client.change(path, text)
    (diagnostic,) = client.diagnostics(path)
    line, column = place(text, 'effector: "')
    start, end = diagnostic["range"]["start"], diagnostic["range"]["end"]
    assert (start["line"], start["character"]) == (line, column - 1)
    assert end["character"] - start["character"] == len('"xxhead"')


def test_rename_changes_all_files_with_the_name(client: Client, path: Path) -> None:
    line, column = place(TEXT, "\n  search:")
    spot = {"textDocument": {"uri": path.as_uri()}, "position": {"line": line, "character": 3}}
    whole = client.ask("textDocument/prepareRename", spot)
    assert (whole["start"]["character"], whole["end"]["character"]) == (2, column - 1)
    edit = client.ask("textDocument/rename", {**spot, "newName": "look_for"})
    (change,) = edit["documentChanges"]
    assert change["textDocument"]["uri"] == path.as_uri()
    assert len(change["edits"]) == sum(
        len(re.findall(r"\bsearch\b", text.partition("#")[0]))
        for text in TEXT.splitlines()
        if not text.startswith("description")
    )
    assert {each["newText"] for each in change["edits"]} == {"look_for"}
    assert client.ask("textDocument/rename", {**spot, "newName": "search"}) is None
    told = client.refused("textDocument/rename", {**spot, "newName": "look for"})
    assert "'look for' is not a name" in told
    told = client.refused("textDocument/rename", {**spot, "newName": "track"})
    assert "there is a 'track' already" in told


def test_a_controller_in_a_composition_reports_how_it_is_declared(
    client: Client, path: Path
) -> None:
    shown = client.at("hover", path, *place(TEXT, "actions: ["))["contents"]["value"]
    assert shown.startswith("```yaml\nsearch:") and "head.uniform" in shown
    assert "track:" not in shown


def test_compositions_are_coloured(client: Client, path: Path) -> None:
    legend = client.capabilities["semanticTokensProvider"]["legend"]["tokenTypes"]
    params = {"textDocument": {"uri": path.as_uri()}}
    data = client.ask("textDocument/semanticTokens/full", params)["data"]
    lines, words, line, column = TEXT.splitlines(), [], 0, 0
    for step, start, length, kind, _ in zip(*[iter(data)] * 5, strict=True):
        line, column = line + step, start if step else column + start
        words.append((lines[line][column : column + length], legend[kind]))
    assert {("search", "function"), ("◁", "operator"), ("spring", "type")} <= {*words}


def test_a_document_is_formatted(client: Client, path: Path) -> None:
    params = {
        "textDocument": {"uri": path.as_uri()},
        "options": {"tabSize": 2, "insertSpaces": True},
    }
    assert client.ask("textDocument/formatting", params) == []
    client.change(path, TEXT.replace("kind: program", "kind:   program\n\n"))
    (edit,) = client.ask("textDocument/formatting", params)
    assert edit["newText"] == TEXT.replace("kind: program", "kind: program\n")
    client.change(path, "a: [")
    assert client.ask("textDocument/formatting", params) == []
