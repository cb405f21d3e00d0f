"""Printed texts: control characters from documents and file names never reach the terminal."""

from __future__ import annotations

import io
import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cbdsl.cli.process.legible_output import LegibleStream, legible_output, raw
from tests.cli.test_main import cb
from tests.conftest import ROOT

TITLE, CLEAR, BELL, C1 = "\x1b]0;owned\x07", "\x1b[2J", "\x07", "\x9b31m"
PAYLOAD = f"{TITLE}{CLEAR}{C1}\r\u202e\n::owned::"
HARMFUL = "\x1b\x07\x9b\r\u202e\x08"


@given(st.text())
def test_legible_stream_writes_no_unseen_character(text: str) -> None:
    target = io.StringIO()
    LegibleStream(target).write(text)
    written = target.getvalue()
    assert not set(written) & {chr(c) for c in (*range(9), *range(11, 32), *range(127, 160))}
    if text.replace("\n", "").isprintable():
        assert written == text


@given(st.text())
def test_legible_stream_keeps_json_valid(text: str) -> None:
    target = io.StringIO()
    LegibleStream(target).write(json.dumps({"name": text}, ensure_ascii=False))
    assert json.loads(target.getvalue()) == {"name": text}


def test_legible_output_leaves_the_streams_as_they_were() -> None:
    streams = sys.stdout, sys.stderr
    with legible_output():
        assert raw(sys.stdout) is streams[0]
    assert (sys.stdout, sys.stderr) == streams


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Change to a folder with harmful file names and harmful texts in documents."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "programs").mkdir()
    name = f"x{PAYLOAD}"
    text = json.dumps(
        {"cbdsl": 1, "kind": "program", "name": "x", "description": PAYLOAD, "robot": "dexter"}
    )
    for file in (f"programs/{name}.yaml", "programs/x.yaml", f"{name}.json", f"{name}.npz"):
        Path(file).write_text(text)
    Path("p.episodes.jsonl").write_text(json.dumps({"program": PAYLOAD}) + "\n")
    Path("m.urdf").write_text("<robot name='r'><link name='&#x9b;31m&#x202e;'/></robot>")
    return tmp_path


NAME = f"x{PAYLOAD}"
COMMANDS = (
    ("list",),
    ("validate", "."),
    ("validate", "--format", "json", "."),
    ("validate", "--format", "github", "."),
    ("fmt", "--check", "."),
    ("fmt", f"programs/{NAME}.yaml"),
    ("show", "program", f"programs/{NAME}.yaml"),
    ("replay", f"{NAME}.json"),
    ("replay", f"{NAME}.npz"),
    ("replay", PAYLOAD),
    ("report", f"{NAME}.json"),
    ("run", f"programs/{NAME}.yaml"),
    ("run", PAYLOAD),
    ("explain", PAYLOAD),
    ("export", "tree", f"programs/{NAME}.yaml"),
    ("new", "robot", "r", "--urdf", "m.urdf"),
    ("new", "robot", PAYLOAD, "--urdf", "m.urdf"),
    ("run", "nowhere"),
    ("show", "program", "nowhere"),
    ("show", "knowledge"),
    ("schema", "program", "--write", PAYLOAD),
    ("new", "program", "y", "--to", PAYLOAD),
    ("validate", f"programs/{NAME}.yaml", "--fix"),
    ("fmt", "--diff", "."),
    ("learn", "searchtrack", "--out", "p.yaml", "--resume", "--backend", "kinematic"),
    (PAYLOAD,),
    ("--" + PAYLOAD,),
)


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: " ".join(words)[:20].strip())
def test_command_on_harmful_names_and_texts_prints_legible_text(
    words: tuple[str, ...],
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    cb(monkeypatch, *words)
    printed = capsys.readouterr()
    assert not set(printed.out + printed.err) & set(HARMFUL)
    # GitHub obeys a line that begins with a command, also after blanks.
    lines = (printed.out + printed.err).splitlines()
    assert not [line for line in lines if line.lstrip().startswith("::owned")]


@pytest.mark.slow
@pytest.mark.parametrize("words", [("list",), ("validate", "."), ("replay", f"{NAME}.json")])
def test_command_on_a_terminal_prints_its_own_escapes_alone(
    words: tuple[str, ...], folder: Path
) -> None:
    control, terminal = pty.openpty()
    process = subprocess.Popen(
        [str(Path(sys.executable).parent / "cb"), *words],
        stdin=subprocess.DEVNULL, stdout=terminal, stderr=terminal, cwd=folder,
    )  # fmt: skip
    os.close(terminal)
    printed = b""
    while True:
        try:
            part = os.read(control, 65536)
        except OSError:
            break
        if not part:
            break
        printed += part
    process.wait()
    assert printed and b"\x1b]" not in printed and b"\x1b[2J" not in printed
    assert b"\x07" not in printed and "\x9b".encode() not in printed
    assert ROOT.exists()


def test_output_to_a_closed_terminal_is_discarded() -> None:
    ours, theirs = os.openpty()
    with open(theirs, "w") as terminal:
        stream = LegibleStream(terminal)
        os.close(ours)
        for _ in range(2):
            stream.write("the robot stands\n")
            stream.flush()
