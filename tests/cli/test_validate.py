"""``cb validate``: formats, the standard input, strictness, ignores and avoided imports."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

from cbdsl.cli.validation import FORMATS, check_paths
from cbdsl.diagnostics.catalogue import catalogue
from cbdsl.diagnostics.json_format import VERSION
from cbdsl.yaml_text.library import shipped
from tests.cli.test_main import BAD, HEAVY, ROOT, cb

CLASH = BAD / "programs" / "type_clash.yaml"
UNUSED = BAD / "programs" / "unused_controller.yaml"
CB = (sys.executable, "-c", "from cbdsl.cli.main import main; main()")
SEARCHTRACK = shipped() / "programs" / "searchtrack.yaml"


@pytest.fixture
def printed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """Return a function that runs ``cb validate`` and returns its exit code and output."""

    def run(*words: str) -> tuple[int, str]:
        code = cb(monkeypatch, "validate", *words)
        return code, capsys.readouterr().out

    return run


def standard_input(monkeypatch: pytest.MonkeyPatch, data: bytes) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))


# -- formats ---------------------------------------------------------------------------------


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_has_every_finding_and_the_same_exit_code(form: str, printed: Any) -> None:
    code, text = printed("--format", form, str(BAD / "programs"))
    _, plain = printed("--format", "json", str(BAD / "programs"))
    diagnostics = json.loads(plain)["findings"]
    codes = sorted(diagnostic["code"] for diagnostic in diagnostics)
    found = {
        "text": lambda: re.findall(r"^\S+?:\d+:\d+: (CB\d{3})", text, re.MULTILINE),
        "json": lambda: [diagnostic["code"] for diagnostic in json.loads(text)["findings"]],
        "github": lambda: re.findall(r"title=(CB\d{3})::", text),
        "sarif": lambda: [r["ruleId"] for r in json.loads(text)["runs"][0]["results"]],
    }
    assert code == 1
    assert len(codes) > 100
    assert sorted(found[form]()) == codes


def test_json_is_versioned_and_complete(printed: Any) -> None:
    code, text = printed("--json", str(CLASH))
    data = json.loads(text)
    assert code == 1
    counts = ["errors", "warnings", "notes", "left_out", "others", "unreadable"]
    assert list(data) == ["version", "documents", *counts, "findings"]
    assert (data["version"], data["documents"], data["errors"]) == (VERSION, 1, 1)
    (diagnostic,) = data["findings"]
    assert (diagnostic["code"], diagnostic["severity"]) == ("CB504", "error")
    assert diagnostic["place"]["line"] == 8
    files = [Path(related["place"]["file"]).name for related in diagnostic["related"]]
    assert files == [CLASH.name, "dexter.yaml", "dexter.yaml"]


def test_keys_of_json_are_documented(printed: Any) -> None:
    page = (ROOT / "docs" / "ci.md").read_text("utf-8")
    _, text = printed("--json", str(CLASH))

    def keys(value: Any) -> set[str]:
        if isinstance(value, dict):
            return set(value) | {key for inner in value.values() for key in keys(inner)}
        return {key for inner in value for key in keys(inner)} if isinstance(value, list) else set()

    assert {key for key in keys(json.loads(text)) if f"`{key}`" not in page} == set()


def test_github_annotations_are_escaped(tmp_path: Path, printed: Any) -> None:
    path = tmp_path / "a,b:100%.yaml"
    path.write_bytes(CLASH.read_bytes())
    _, text = printed("--format", "github", str(path))
    warning, error = text.splitlines()
    assert warning.startswith("::warning ") and "CB704" in warning
    match = re.fullmatch(r"::error (?P<properties>[^:]*)::(?P<message>.*)", error)
    assert match
    properties = dict(pair.split("=") for pair in match["properties"].split(","))
    assert unquote(properties["file"]) == str(path)
    assert (properties["line"], properties["col"], properties["endColumn"]) == ("8", "16", "28")
    assert "stereo.hue_4" in match["message"] and "%0A" in match["message"]


def test_github_format_of_valid_documents_is_empty(printed: Any) -> None:
    assert printed("--format", "github", str(SEARCHTRACK)) == (0, "")


def test_sarif_names_rules_and_regions(printed: Any) -> None:
    _, text = printed("--format", "sarif", str(BAD))
    log = json.loads(text)
    assert log["version"] == "2.1.0" and log["$schema"].endswith("sarif-schema-2.1.0.json")
    (run,) = log["runs"]
    rules = run["tool"]["driver"]["rules"]
    assert len({rule["id"] for rule in rules}) == len(rules)
    for rule in rules:
        assert rule["shortDescription"]["text"] == catalogue()[rule["id"]].title
        assert rule["defaultConfiguration"]["level"] in ("error", "warning")
    for result in run["results"]:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
        assert result["level"] in ("error", "warning")
        assert result["message"]["text"]
        for location in [*result["locations"], *result.get("relatedLocations", [])]:
            require_location(location)


def require_location(location: dict[str, Any]) -> None:
    """Check a location against SARIF 2.1.0 (sections 3.28 to 3.30)."""
    physical = location["physicalLocation"]
    uri, region = physical["artifactLocation"]["uri"], physical["region"]
    assert re.fullmatch(r"[A-Za-z0-9._~!$&'()*+,;=:@%/-]+", uri)
    assert Path(unquote(uri.removeprefix("file://"))).exists()
    assert region["startLine"] >= 1 and region["startColumn"] >= 1
    assert region["endColumn"] > region["startColumn"]
    assert ("id" in location) == ("message" in location)


def test_unknown_format_is_a_wrong_call(printed: Any) -> None:
    assert printed("--format", "xml", str(CLASH))[0] == 2


def test_colour_is_printed_only_on_terminals(monkeypatch: pytest.MonkeyPatch, printed: Any) -> None:
    assert "\x1b[" not in printed(str(CLASH))[1]
    monkeypatch.setattr(
        "cbdsl.diagnostics.text_format.sys.stdout.isatty", lambda: True, raising=False
    )
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    assert "\x1b[" in printed(str(CLASH))[1]
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[" not in printed(str(CLASH))[1]


@pytest.mark.parametrize("form", FORMATS)
def test_no_format_imports_anything_heavy(form: str) -> None:
    script = (
        "import sys\nfrom cbdsl.cli.main import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    code = end.code\n"
        f"sys.exit(code or ', '.join(m for m in {HEAVY} if m in sys.modules) or 0)"
    )
    words = ["validate", "--format", form, str(UNUSED)]
    run = subprocess.run([sys.executable, "-c", script, *words], capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")


# -- the standard input ----------------------------------------------------------------------


def test_standard_input_stands_for_a_file(monkeypatch: pytest.MonkeyPatch, printed: Any) -> None:
    standard_input(monkeypatch, CLASH.read_bytes().replace(b"stereo.hue_4", b"stereo.hue_44"))
    code, text = printed("-", "--stdin-name", str(CLASH))
    assert code == 1
    assert f"{CLASH}:8:16: CB501" in text
    assert "reference: stereo.hue_44" in text  # the snippet is from the standard input


def test_standard_input_needs_no_name(monkeypatch: pytest.MonkeyPatch, printed: Any) -> None:
    standard_input(monkeypatch, SEARCHTRACK.read_bytes())
    assert printed("-") == (0, "1 document, no findings\n")
    standard_input(monkeypatch, b"\xff")
    code, text = printed("-")
    assert code == 1 and text.startswith("stdin.yaml:1:1: CB102")


# -- warnings and ignores --------------------------------------------------------------------


def test_strictness_makes_warnings_count() -> None:
    assert check_paths([str(UNUSED)], {}) == 0
    assert check_paths([str(UNUSED)], {}, strict=True) == 1
    assert check_paths([str(SEARCHTRACK)], {}, strict=True) == 0


IDLE = "  idle: {potential: spring, reference: 0, feedback: head, effector: head}"
HEAD = "cbdsl: 1\nkind: program\nname: own\nrobot: dexter\ncontrollers:\n"
REST = (
    "\n  ahead: {potential: spring, reference: 0, feedback: head, effector: head}\n"
    + "actions: [ahead]\n"
)


def codes(folder: Path, text: str) -> list[str]:
    from cbdsl.checking.document import check_document
    from cbdsl.checking.suppression import apply_suppressions
    from cbdsl.yaml_text.library import Library

    path = folder / "own.yaml"
    path.write_text(text, encoding="utf-8")
    return [d.code for d in apply_suppressions(check_document(path), [path], Library())]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (HEAD + IDLE + REST, ["CB701"]),
        (HEAD + IDLE + "  # cb: ignore CB701 for later" + REST, []),
        (HEAD + "  # cb: ignore CB701 for later\n" + IDLE + REST, []),
        (HEAD + "  # cb: ignore CB701 for later\n\n  # more\n" + IDLE + REST, []),
        (HEAD + IDLE + "  # cb: ignore CB701" + REST, ["CB802"]),
        (HEAD + IDLE + "  # cb: ignore" + REST, ["CB701", "CB803"]),
        (HEAD + IDLE + "  # cb: ignore CB70 for later" + REST, ["CB701", "CB803"]),
        (HEAD + IDLE + "  # cb: ignore CB702 for later" + REST, ["CB701", "CB801"]),
        (HEAD + IDLE + REST + "# cb: ignore CB701 too late\n", ["CB701", "CB801"]),
        (HEAD + IDLE + REST + 'description: "a # cb: ignore CB701 b"\n', ["CB701"]),
        (HEAD + IDLE + REST + "description: >\n  a\n  # cb: ignore CB701 b\n", ["CB701"]),
        (HEAD + IDLE + REST + "stage: [ # cb: ignore CB104 half a document", []),
        (HEAD + IDLE.replace("head,", "hed,") + " # cb: ignore CB501 not yet" + REST, []),
    ],
)
def test_comment_silences_one_finding(tmp_path: Path, text: str, wanted: list[str]) -> None:
    assert codes(tmp_path, text) == wanted


def test_silenced_error_still_keeps_a_program_from_running(tmp_path: Path) -> None:
    from cbdsl.checking.program import check_program
    from cbdsl.diagnostics.errors import DiagnosticsError

    text = HEAD + IDLE.replace("head,", "hed,") + " # cb: ignore CB501 not yet" + REST
    assert codes(tmp_path, text) == []
    with pytest.raises(DiagnosticsError, match="CB501"):
        check_program(tmp_path / "own.yaml")


# -- checked files ---------------------------------------------------------------------------


def test_name_stands_for_its_documents(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, printed: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    code, text = printed("posture", "table_right", "dexter")
    assert code == 0 and text.endswith(" documents, no findings\n")
    (tmp_path / "own.yaml").write_text(HEAD + IDLE + REST, encoding="utf-8")
    code, text = printed("own")
    assert code == 0 and text.startswith("own.yaml:6:3: CB701")


def test_unknown_name_is_a_wrong_call(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "validate", "serchtrack") == 2
    assert "did you mean 'searchtrack'?" in capsys.readouterr().err


def test_missing_file_with_the_name_of_a_document_is_explained(printed: Any) -> None:
    code, text = printed(str(SEARCHTRACK.with_name("serchtrack.yaml")))
    assert code == 1 and f"did you mean '{SEARCHTRACK}'?" in text


# -- bounds ----------------------------------------------------------------------------------


def test_validate_reports_only_the_first_100_diagnostics_of_a_file(
    tmp_path: Path, printed: Any
) -> None:
    path = tmp_path / "flood.yaml"
    path.write_text(HEAD + REST + "policy:\n" + "".join(f"  q{i}: a{i}\n" for i in range(1500)))
    code, text = printed("--json", str(path))
    data = json.loads(text)
    assert code == 1
    assert data["left_out"] > 1000 and len(data["findings"]) == 100


# -- paths that are not regular files ---------------------------------------------------------


def test_special_files_are_one_finding_each_and_the_rest_is_checked(tmp_path: Path) -> None:
    (tmp_path / "type_clash.yaml").write_bytes(CLASH.read_bytes())
    os.mkfifo(tmp_path / "pipe.yaml")
    for name, target in {"zero": "/dev/zero", "loop": "loop.yaml", "lost": "gone.yaml"}.items():
        (tmp_path / f"{name}.yaml").symlink_to(target)
    with (tmp_path / "large.yaml").open("wb") as file:
        file.write(b"cbdsl: 1\n")
        file.truncate(1 << 40)  # a sparse file, which needs no space on the disk
    (tmp_path / "folder.yaml").mkdir()
    (tmp_path / "folder.yaml" / "up.yaml").symlink_to("..")
    command = [*CB, "validate", "--json", "."]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    diagnostics = json.loads(done.stdout)["findings"]
    assert {(each["place"]["file"], each["code"]) for each in diagnostics} == {
        ("large.yaml", "CB108"),
        *((f"{name}.yaml", "CB101") for name in ("loop", "lost", "pipe", "zero")),
        ("type_clash.yaml", "CB504"),
    }
    assert len(diagnostics) == 6
    assert all(not each["nearest"] for each in diagnostics if each["code"] == "CB101")


@pytest.mark.parametrize("document", ["program", "robot"])
def test_command_that_is_given_a_pipe_does_not_wait(document: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.yaml")
    words = {"program": ["run", "pipe.yaml"], "robot": ["validate", "robot.yaml"]}[document]
    robot = "cbdsl: 1\nkind: robot\nname: robot\nmodel: pipe.yaml\nbase: base\neffectors:\n"
    robot += "  arm: {joints: [joint]}\ncontrol: {rate: 120 Hz, tasks: {}}\n"
    (tmp_path / "robot.yaml").write_text(robot, "utf-8")
    done = subprocess.run([*CB, *words], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "it is a named pipe" in done.stdout


def test_standard_input_without_an_end_is_too_large(
    monkeypatch: pytest.MonkeyPatch, printed: Any
) -> None:
    with open("/dev/zero", "rb") as endless:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(endless))
        code, text = printed("-")
    assert code == 1 and "CB108" in text
