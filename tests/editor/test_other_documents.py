"""Documents of other tools, which are ignored, and unsaved documents, which are served."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.documents.test_ownership import FOREIGN
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
WRONG = TEXT.replace("potential: spring", "potential: sprung", 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("others")


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[Client]:
    client = Client(folder)
    yield client
    assert client.close() == 0


@pytest.mark.parametrize("text", FOREIGN.values(), ids=FOREIGN)
def test_yaml_of_another_tool_has_no_answers(client: Client, folder: Path, text: str) -> None:
    path = folder / "docker-compose.yml"
    client.open(path, text)
    assert client.diagnostics(path) == []
    document = {"textDocument": {"uri": path.as_uri()}}
    options = {"options": {"tabSize": 2, "insertSpaces": True}}
    assert client.ask("textDocument/formatting", {**document, **options}) == []
    assert client.ask("textDocument/semanticTokens/full", document)["data"] == []
    for method in ("hover", "definition", "prepareRename"):
        assert client.at(method, path, 0, 1) is None
    if text:
        assert client.at("completion", path, 0, 1) is None


def test_a_document_that_becomes_one_of_another_tool_loses_its_findings(
    client: Client, folder: Path
) -> None:
    path = folder / "changing.yaml"
    client.open(path, WRONG)
    assert client.diagnostics(path)
    client.change(path, "services: {}\n")
    assert client.diagnostics(path) == []
    client.change(path, "kind: program\n")
    assert client.diagnostics(path)


def test_a_file_in_a_folder_of_documents_has_findings(client: Client, folder: Path) -> None:
    path = folder / "programs" / "new.yaml"
    client.open(path, "")
    assert [each["code"] for each in client.diagnostics(path)] == ["CB105"]


@pytest.mark.parametrize(
    "uri",
    [
        "untitled:Untitled-1",
        "untitled:/programs/a%20new.yaml",
        "untitled:",
        "git:/programs/searchtrack.yaml?%7B%22ref%22%3A%22HEAD%22%7D",
        "inmemory://model/1",
        "Untitled-2",
        "file:///%00a.yaml",
    ],
)
def test_a_document_in_no_file_has_findings_and_answers(client: Client, uri: str) -> None:
    client.open_uri(uri, WRONG)
    document = {"textDocument": {"uri": uri}}
    line = WRONG[: WRONG.index("sprung")].count("\n")
    start = len(WRONG[: WRONG.index("sprung")].rsplit("\n", 1)[1])
    place = {**document, "position": {"line": line, "character": start}}
    assert client.ask("textDocument/completion", place)["items"]
    (diagnostic,) = client.published[uri]
    assert diagnostic["range"]["start"] == place["position"]
    params = {**document, "range": diagnostic["range"], "context": {"diagnostics": []}}
    (action,) = client.ask("textDocument/codeAction", params)
    assert list(action["edit"]["changes"]) == [uri]
    there = {"line": WRONG[: WRONG.index("robot: ")].count("\n"), "character": 9}
    robot = client.ask("textDocument/definition", {**document, "position": there})
    assert robot["uri"] == (ROOT / "robots" / "dexter.yaml").as_uri()
    client.tell("textDocument/didClose", document)
    client.ask("textDocument/completion", place)
    assert client.published[uri] == []


def test_documents_in_no_file_are_kept_apart_from_each_other_and_from_files(
    client: Client, folder: Path
) -> None:
    saved = folder / "same.yaml"
    saved.write_text(TEXT, encoding="utf-8")
    client.open(saved, TEXT.replace("name: searchtrack", "name: same"))
    client.open_uri("untitled:same.yaml", WRONG)
    client.open_uri("git:/elsewhere/same.yaml", "services: {}\n")
    assert client.diagnostics(saved) == []
    assert len(client.published["untitled:same.yaml"]) == 1
    assert client.published["git:/elsewhere/same.yaml"] == []


def test_a_robot_that_a_program_named_before_keeps_its_own_findings(tmp_path: Path) -> None:
    """Robots found by name have a path relative to the folder of the server."""
    robot = (ROOT / "robots" / "dexter.yaml").read_text("utf-8")
    (tmp_path / "robots").mkdir()
    path = tmp_path / "robots" / "twin.yaml"
    faulty = robot.replace("name: dexter", "name: twin").replace(
        "model: dexter.urdf", f"model: {ROOT / 'robots' / 'gone.urdf'}"
    )
    path.write_text(faulty, encoding="utf-8")
    client = Client(tmp_path)
    program = tmp_path / "track.yaml"
    client.open(program, TEXT.replace("robot: dexter", "robot: twin"))
    client.diagnostics(program)
    client.open(path, faulty)
    assert [each["code"] for each in client.diagnostics(path)] == ["CB301"]
    client.close()


def test_renaming_leaves_yaml_of_other_tools_alone(tmp_path: Path) -> None:
    (tmp_path / "programs" / "stages").mkdir(parents=True)
    stage = tmp_path / "programs" / "stages" / "web.yaml"
    text = "cbdsl: 1\nkind: stage\nname: web\nrobot: dexter\n"
    stage.write_text(text, encoding="utf-8")
    other = tmp_path / "ci.yml"
    other.write_text("deploy:\n  stage: web\n", encoding="utf-8")
    client = Client(tmp_path)
    client.open(stage, text)
    place = {"textDocument": {"uri": stage.as_uri()}, "position": {"line": 2, "character": 7}}
    changes = client.ask("textDocument/rename", {**place, "newName": "net"})["documentChanges"]
    assert other.as_uri() not in str(changes) and stage.as_uri() in str(changes)
    client.close()
