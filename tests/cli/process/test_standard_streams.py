"""Closed standard streams: a command runs, and reports a stream that it needs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.test_main import cb as typed

CB = [sys.executable, "-c", "from cbdsl.cli.main import main; main()"]
COMMANDS = [
    ["list"],
    ["show", "types"],
    ["explain", "CB203"],
    ["export", "tree", "searchtrack"],
    ["validate", "reach"],
    ["validate", "--json", "nothing_of_this_name"],
    ["--help"],
    ["run", "posture", "--backend", "kinematic"],
]


def cb(words: list[str], closed: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run ``cb`` with some of its streams closed, as by a shell."""
    shell = ["sh", "-c", f'exec "$@" {closed}', "sh"]
    return subprocess.run(
        [*shell, *CB, *words], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_command_with_closed_streams_ends_as_with_open_ones(
    words: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    expected = typed(monkeypatch, *words)  # in this process, whose streams are open
    message = capsys.readouterr().err
    closed = cb(words, ">&-", tmp_path)
    assert closed.returncode == expected
    assert closed.stderr == message and "internal error" not in closed.stderr
    assert cb(words, ">&- 2>&- <&-", tmp_path).returncode == expected


def test_closed_standard_error_prints_nothing_among_the_output(tmp_path: Path) -> None:
    done = cb(["validate", "nothing_of_this_name"], "2>&-", tmp_path)
    assert (done.returncode, done.stdout) == (2, "")


@pytest.mark.parametrize("words", [["validate", "-"], ["fmt", "-"]], ids=" ".join)
def test_closed_standard_input_that_is_read_is_named(words: list[str], tmp_path: Path) -> None:
    done = cb(words, "<&-", tmp_path)
    assert done.returncode == 2
    assert done.stderr == "cb: the standard input is closed; name a file instead of '-'\n"


@pytest.mark.parametrize("closed", ["<&-", ">&-"])
def test_language_server_without_streams_says_so(closed: str, tmp_path: Path) -> None:
    pytest.importorskip("pygls")
    done = cb(["lsp"], f"{closed} {'' if '<' in closed else '</dev/null'}", tmp_path)
    assert done.returncode == 2
    assert "cb: cb lsp needs the standard input and output" in done.stderr


def test_file_never_takes_the_number_of_a_closed_stream(tmp_path: Path) -> None:
    """Files get descriptors above 2, so that output of C libraries is not written into them."""
    code = (
        "from cbdsl.cli.process.standard_streams import fill_closed_streams; "
        "fill_closed_streams(); "
        f"import os; file = open({str(tmp_path / 'kept')!r}, 'w'); "
        "[os.write(number, b'noise') for number in (1, 2)]; print(file.fileno(), file=file)"
    )
    shell = ["sh", "-c", 'exec "$@" >&- 2>&- <&-', "sh", sys.executable, "-c", code]
    subprocess.run(shell, check=True, timeout=60, env={**os.environ})
    assert int((tmp_path / "kept").read_text("utf-8")) > 2
