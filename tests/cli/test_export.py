"""``cb export``: trees of policies, and formats of packages."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from cbdsl.reporting.export_format import EXPORTS
from tests.cli.test_main import cb
from tests.conftest import ROOT
from tests.plugins.installed import on_path, refresh, write_package

RECORDED = "from cbdsl.reporting.export_format import Export\n"


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """Yield a folder of packages; forget it after each test."""
    with on_path(tmp_path):
        yield tmp_path
    refresh()


def test_export_tree_prints_a_policy(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "export", "tree", "searchtrack") == 0
    assert capsys.readouterr().out.startswith('<root BTCPP_format="4"')
    assert cb(monkeypatch, "export", "tree", "searchtrak") == 2
    assert "did you mean 'searchtrack'" in capsys.readouterr().err


def test_export_tree_needs_no_stage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "programs" / "searchtrack.yaml").read_text("utf-8")
    file = tmp_path / "searchtrack.yaml"
    file.write_text(re.sub(r"^stage: .*\n", "", text, flags=re.MULTILINE), encoding="utf-8")
    assert cb(monkeypatch, "export", "tree", str(file)) == 0
    assert capsys.readouterr().out.startswith('<root BTCPP_format="4"')


def install(folder: Path, text: str) -> None:
    """Install a package with one export, ``text``."""
    points = {"cbdsl.exports": {"text": "texts:TEXT"}}
    write_package(folder, "texts", points, texts=text)
    EXPORTS.refresh()


WRITER = """
def write(recordings: "Unknown", target, *, digits: int = 3) -> str:
    "Write the last time."
    (recorded,) = recordings
    target.write_text(f"{recorded.arrays['time'][-1]:.{digits}f}")
    return "one number"
TEXT = Export(write, suffix=".txt")
"""


def test_export_of_a_package_writes_each_recording_with_its_options(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install(folder, RECORDED + WRITER)
    tapes = folder / "tapes"
    words = ("run", "posture", "--backend", "kinematic", "--seed", "3")
    assert cb(monkeypatch, *words, "--record", str(tapes)) == 0
    capsys.readouterr()
    assert cb(monkeypatch, "export", "text", str(tapes), "--digits", "1") == 0
    assert capsys.readouterr().out == f"{tapes / 'episode_3.txt'}: one number\n"
    assert re.fullmatch(r"\d+\.\d", (tapes / "episode_3.txt").read_text())
    missing = tapes / "none" / "x.txt"
    assert cb(monkeypatch, "export", "text", str(tapes), "--out", str(missing)) == 2
    assert f"{missing}: No such file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("TEXT = 3", "is a int, not an Export"),
        ("TEXT = Export(print)", "has not one of 'suffix' and 'folder'"),
        ("TEXT = Export(lambda r, t: '', suffix='.txt')", "has no help"),
        (WRITER.replace("int", "Lost"), "has an option without a type at run time"),
        ("raise RuntimeError('no licence')", "no licence"),
    ],
)
def test_faulty_export_is_named_with_its_package_and_others_are_listed(
    text: str,
    message: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    install(folder, "from __future__ import annotations\n" + RECORDED + text)
    assert cb(monkeypatch, "export", "--help") == 0
    assert "tree" in capsys.readouterr().out
    assert cb(monkeypatch, "export", "text", "tapes", "--digits", "1") == 2
    error = capsys.readouterr().err
    assert message in error and "texts 1.0" in error and error.count("\n") == 1


@pytest.mark.parametrize("name", ["mcap", "ros2", "lerobot"])
def test_export_that_is_not_installed_names_its_extra_in_one_message(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(EXPORTS, "_offers", {})
    assert cb(monkeypatch, "export", name, "tapes", "--task", "x") == 2
    expected = f"cb: export '{name}' comes with cbdsl[{name}], which is not installed: pip install"
    assert capsys.readouterr().err == f"{expected} 'cbdsl[{name}]'\n"
