"""Commands of other packages: listed, run, and reported if they cannot be used."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.cli.commands import COMMANDS
from tests.cli.test_main import cb
from tests.plugins.installed import write_package

DOCUMENTED = "def faulty():\n    '''Do nothing.'''\n"


def test_cb_of_a_packages_command_runs_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "tally", "searchtrack", "--episodes", "2") == 0
    assert capsys.readouterr().out == "2 of 2 episodes are rewarded\n"


def test_cb_help_lists_a_packages_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "--help") == 0
    assert "Count the rewarded episodes" in capsys.readouterr().out


def test_error_of_a_packages_command_is_one_message(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cb(monkeypatch, "tally", "serchtrack") == 2
    error = capsys.readouterr().err
    assert "searchtrack" in error and "Traceback" not in error


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("faulty = 3\n", "is a int, neither a function nor a typer.Typer"),
        ("def faulty():\n    pass\n", "has no help"),
        ("def faulty(x: 'int | str'):\n    '''Do nothing.'''\n", "is no command"),
        ("raise RuntimeError('no licence')\n", "no licence"),
    ],
)
def test_faulty_command_is_reported_and_others_run(
    text: str,
    message: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    points = {"cbdsl.commands": {"faulty": "bad_command:faulty"}}
    write_package(folder, "bad", points, bad_command=text)
    COMMANDS.refresh()
    assert cb(monkeypatch, "--help") == 0
    shown = capsys.readouterr()
    assert message in shown.err and "bad 1.0" in shown.err and "tally" in shown.out
    assert cb(monkeypatch, "faulty") == 2
    assert message in capsys.readouterr().err
    assert cb(monkeypatch, "tally", "searchtrack", "--episodes", "1") == 0


def test_built_in_command_is_not_replaced(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    points = {"cbdsl.commands": {"run": "bad_command:faulty"}}
    write_package(folder, "bad", points, bad_command=DOCUMENTED)
    COMMANDS.refresh()
    assert cb(monkeypatch, "--help") == 0
    shown = capsys.readouterr()
    assert "bad 1.0" in shown.err and "this name is built in" in shown.err
    assert "Run a program on a robot" in shown.out


@pytest.mark.parametrize(
    ("words", "package"),
    [
        (("reproduce", "all"), "cbdsl-reproduction"),
        (("why", "reach", "--try"), "cbdsl[why]"),
        (("playground", "take", "--no-open"), "cbdsl[report]"),
    ],
)
def test_command_of_a_missing_package_names_the_package(
    words: tuple[str, ...],
    package: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(COMMANDS, "_offers", {})
    assert cb(monkeypatch, *words) == 2
    told = capsys.readouterr().err
    assert f"pip install '{package}'" in told and told.count("\n") == 1


@pytest.mark.parametrize("words", [("serve", "dexter", "--seed", "3"), ("watchdog", "dexter")])
def test_subcommand_of_a_missing_distribution_names_its_extra(
    words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(COMMANDS, "_offers", {})
    assert cb(monkeypatch, "drive", *words) == 2
    assert "which is not installed: pip install 'cbdsl[ros2]'" in capsys.readouterr().err


def test_dotted_name_adds_a_command_to_a_group(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    points = {"cbdsl.commands": {"drive.wave": "waves:faulty"}}
    write_package(folder, "waves", points, waves=f"{DOCUMENTED}    print('hello')\n")
    COMMANDS.refresh()
    assert cb(monkeypatch, "drive", "wave") == 0
    assert capsys.readouterr().out == "hello\n"
    assert cb(monkeypatch, "drive.wave") == 2
