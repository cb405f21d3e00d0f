"""Output of C code, kept apart from the output of Python."""

from __future__ import annotations

import subprocess
import sys

SCRIPT = """
import ctypes, sys
from cbdsl.cli.process.native_output import shown_on_failure

with shown_on_failure():
    ctypes.CDLL(None).puts(b"noise")
    print("said \u25c1")
    if {failing}:
        raise ValueError("on purpose")
print("said afterwards")
"""


def run(failing: bool) -> subprocess.CompletedProcess[str]:
    script = SCRIPT.format(failing=failing)
    return subprocess.run([sys.executable, "-c", script], capture_output=True, encoding="utf-8")


def test_native_output_of_a_successful_command_is_dropped() -> None:
    done = run(failing=False)
    assert (done.stdout, done.stderr) == ("said \u25c1\nsaid afterwards\n", "")


def test_native_output_of_a_failed_command_is_printed() -> None:
    done = run(failing=True)
    assert done.stdout == "said \u25c1\n"
    assert done.stderr.startswith("noise\nTraceback") and "on purpose" in done.stderr
