"""The command line: exit codes, messages and modules that it does not import."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cbdsl.cli import main as command
from cbdsl.yaml_text.library import shipped

HEAVY = ("numpy", "numba", "scipy", "networkx", "pybullet", "pinocchio", "cv2", "moderngl", "rich")
ROOT = Path(__file__).resolve().parents[2]
BAD = ROOT / "tests" / "checking" / "bad"


def cb(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> int:
    """Run ``cb`` in this process and return its exit code."""
    monkeypatch.setattr(sys, "argv", ["cb", *arguments])
    try:
        command.main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0


def test_validating_imports_nothing_heavy() -> None:
    script = (
        "import sys\nfrom cbdsl.cli.main import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    code = end.code\n"
        f"sys.exit(code or ', '.join(m for m in {HEAVY} if m in sys.modules) or 0)"
    )
    files = [
        str(path)
        for folder in ("robots", "programs")
        for path in sorted((shipped() / folder).rglob("*.yaml"))
        if "shape: mesh" not in path.read_text("utf-8")  # whose triangles are checked as arrays
    ]
    run = subprocess.run(
        [sys.executable, "-c", script, "validate", *files], capture_output=True, text=True
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert "no findings" in run.stdout


class Interrupted:
    """Object whose destructor is interrupted, where Python cannot propagate exceptions."""

    def __del__(self) -> None:
        raise KeyboardInterrupt


def test_interrupt_swallowed_by_a_destructor_is_raised_again(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "unraisablehook", sys.__unraisablehook__)
    monkeypatch.setattr(sys, "unraisablehook", command._LostInterrupts())
    with pytest.raises(KeyboardInterrupt):
        Interrupted()
        time.sleep(5)
    assert capsys.readouterr().err == ""


def test_other_exception_of_a_destructor_is_printed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    printed: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda lost: printed.append(lost.exc_type))
    monkeypatch.setattr(sys, "unraisablehook", command._LostInterrupts())
    monkeypatch.setattr(Interrupted, "__del__", lambda self: {}[0])
    Interrupted()
    assert printed == [KeyError]


@pytest.mark.parametrize("name", ["none.yaml", ".", "empty", "binary", "wrong_kind"])
def test_wrong_input_is_one_located_message(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    contents = {"empty": b"", "binary": b"\x89PNG\r\n\x1a\n\x00", "wrong_kind": b"kind: robt\n"}
    path = tmp_path / f"{name}.yaml" if name in contents else tmp_path / name
    if name in contents:
        path.write_bytes(contents[name])
    assert cb(monkeypatch, "show", "program", str(path)) == 1
    printed = capsys.readouterr().out
    assert printed.startswith(f"{path}:1:1: CB") or printed.startswith(f"{path}:1:7: CB")
    assert printed.count(": CB") == 1 and "Traceback" not in printed


def test_validate_with_errors_exits_with_1_and_names_the_place(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = BAD / "programs" / "resource_part.yaml"
    assert cb(monkeypatch, "validate", str(path)) == 1
    printed = capsys.readouterr().out
    assert f"{path}:9:15: CB501" in printed and "did you mean 'right_arm.position'?" in printed
    assert printed.endswith("1 error\n")


def test_warnings_exit_with_0(monkeypatch: pytest.MonkeyPatch) -> None:
    assert cb(monkeypatch, "validate", str(BAD / "programs" / "unused_controller.yaml")) == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ("validate",),
        ("validate", "--with", "feature", "programs"),
        ("nonsense",),
        ("explain", "CB000"),
        ("show", "program", "serchtrack"),
        ("show", "program", "searchtrack", "--with", "featur=hue_1"),
        ("show", "resources", "--robot", "dextr"),
    ],
)
def test_wrong_calls_exit_with_2(
    arguments: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, *arguments) == 2
    printed = capsys.readouterr().err
    assert printed and "Traceback" not in printed


def test_folder_without_documents_is_a_wrong_call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cb(monkeypatch, "validate", str(tmp_path)) == 2


def test_internal_error_prints_no_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("broken")

    monkeypatch.delenv("CB_TRACEBACK", raising=False)
    monkeypatch.setattr("cbdsl.diagnostics.text_format.text", fail)
    assert cb(monkeypatch, "validate", str(BAD / "robots" / "crawler.yaml")) == 2
    assert "internal error: RuntimeError: broken" in capsys.readouterr().err


@pytest.mark.parametrize("what", [("types",), ("resources",), ("program", "reachtouch")])
def test_table_of_show_equals_its_json(
    what: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", *what) == 0
    table = capsys.readouterr().out
    assert cb(monkeypatch, "show", *what, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    rows = {"types": "types", "program": "controllers"}
    listed = data[rows[what[0]]] if what[0] in rows else data
    assert listed and all(str(next(iter(row.values()))) in table for row in listed)


def test_programs_stack_is_shown_from_the_highest_priority(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "show", "program", "reachtouch", "--json") == 0
    actions = json.loads(capsys.readouterr().out)["actions"]
    runs = {action["action"]: action["runs"] for action in actions}
    assert runs["reach ◁ touch"] == "touch > approach > orient > posture"


def test_names_are_whole_on_a_narrow_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("cbdsl.cli.output.terminal._WIDTH_OF_PIPES", 80)
    assert cb(monkeypatch, "show", "program", "reachtouch") == 0
    assert "…" not in capsys.readouterr().out


@pytest.mark.parametrize("words", [["--version"], ["run", "--help"], ["validate", "reach"]])
def test_commands_of_the_checker_start_without_numpy(words: list[str]) -> None:
    script = (
        "import sys; sys.modules['numpy'] = sys.modules['numba'] = None; "
        f"sys.argv[1:] = {words!r}; from cbdsl.cli.main import main; main()"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
