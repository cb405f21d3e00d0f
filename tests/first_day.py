"""First day: a reader who knows only pages of the docs, and types the commands in their blocks.

The reader begins with a clone of the project and sets it up as the README says. The commands run in
an empty folder, in a shell with the ``cb`` of the clone. Files hold the blocks that name them.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import time
import urllib.request
from pathlib import Path
from typing import NamedTuple

from tests.conftest import ROOT
from tests.test_docs import blocks

#: Duration of a first day, from the clone to a user-defined program, s.
DAY = 600.0


class Clone(NamedTuple):
    """A clone that is set up, and how long that took, s."""

    folder: Path
    seconds: float


def clone(folder: Path) -> Path:
    """Clone this checkout as it is, without untracked files."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, check=True, text=True,
    )  # fmt: skip
    for name in filter(None, listed.stdout.split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    return folder


def first_command() -> list[str]:
    """Return the README's first command: the part that sets up, and the commands after it."""
    block = next(each for each in blocks(ROOT / "README.md") if each.language == "sh")
    return [part.strip() for part in block.text.split("&&")]


class Reader:
    """Reader of pages, in an empty folder.

    Args:
        clone: Folder of the clone, set up.
        folder: Empty folder.
    """

    def __init__(self, clone: Clone, folder: Path) -> None:
        self._clone, self._folder = clone, folder
        self._began = time.monotonic() - clone.seconds
        self._printed = ""
        binaries = clone.folder / ".venv" / "bin"
        self._environment = {
            **{key: value for key, value in os.environ.items() if key != "PYTHONPATH"},
            "PATH": f"{binaries}:{os.environ['PATH']}", "COLUMNS": "100", "DISPLAY": "",
        }  # fmt: skip

    @property
    def seconds(self) -> float:
        """How much of the day is over, s."""
        return time.monotonic() - self._began

    def read(self, page: str) -> None:
        """Execute a page, block by block."""
        found = [block for block in blocks(ROOT / page) if block.runs]
        for block, follows in zip(found, [*found[1:], None], strict=True):
            if "file" in block.marks:
                file = self._folder / block.marks["file"]
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(block.text, encoding="utf-8")
            elif block.language == "sh":
                shown = follows.text if follows is not None and follows.language == "text" else ""
                fails = re.search(r"^\d+ errors?", shown, re.MULTILINE) is not None
                self._printed = "".join(
                    self.type(line, fails=fails) for line in block.text.splitlines()
                )
            elif block.language == "text" and "not compared" not in block.marks:
                assert_shown(block.text, self._printed)

    def watch(self, command: str) -> str:
        """Type a command that shows a page, look at that until it is over, and end it by Ctrl-C."""
        words = command.replace(".venv/bin/", f"{self._clone.folder}/.venv/bin/")
        process = subprocess.Popen(
            ["bash", "-c", f"exec {words}"], cwd=self._folder, env=self._environment,
            stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert process.stdout is not None
        try:
            return self._looked_at(process)
        finally:
            process.kill()

    def _looked_at(self, process: subprocess.Popen[str]) -> str:
        assert process.stdout is not None
        told, stream = "", None
        for line in process.stdout:
            told += line
            if "live at " in line:
                url = line.split("live at ")[1].strip()
                assert b"<title>reachtouch" in urllib.request.urlopen(url, timeout=30).read()
                stream = urllib.request.urlopen(f"{url}events", timeout=DAY - self.seconds)
            if "stays until" in line:
                break
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0 and stream is not None
        assert b"event: ending" in stream.read()
        return told

    def type(self, line: str, *, fails: bool = False) -> str:
        """Type a line and return its output.

        Raises:
            AssertionError: The command fails or succeeds against the expectation.
            TimeoutExpired: The time of the day has run out.
        """
        done = subprocess.run(
            ["bash", "-euc", line], cwd=self._folder, env=self._environment,
            capture_output=True, text=True, timeout=DAY - self.seconds,
        )  # fmt: skip
        assert (done.returncode != 0) == fails, f"{line}\n{done.stdout}\n{done.stderr}"
        return done.stdout


def assert_shown(shown: str, printed: str) -> None:
    """Assert that a page shows the printed text; a line ``...`` stands for lines left out."""
    rest = "\n".join(line.rstrip() for line in printed.splitlines()) + "\n"
    for part in re.split(r"^\.\.\.\n", shown, flags=re.MULTILINE):
        before, found, rest = rest.partition(part)
        assert found == part, before
