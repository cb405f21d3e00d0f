"""Commands that are interrupted while functions are compiled."""

from __future__ import annotations

import subprocess
import sys

import pytest

from cbdsl.cli.main import is_of_compiler

# An object that the compiler holds when it is interrupted, whose destructor ends the process.
_SCRIPT = """
import os, sys
from cbdsl.cli import main as command

class Module:
    def __del__(self):
        os.abort()

held = {{"__name__": {name!r}, "Module": Module}}
exec("def link():\\n    module = Module()\\n    raise KeyboardInterrupt", held)

def app(*_, **__):
    print("before")
    def run(words):
        try:
            held["link"]()
        except KeyboardInterrupt as interrupt:
            raise ValueError("an exit of the parser") from interrupt
    def exits(words):
        try:
            run(words)
        except ValueError:
            sys.exit(130)
    return exits

command.build_app = app
sys.argv = ["cb", "list"]
command.main()
"""


def test_interrupted_compilation_ends_without_destructors() -> None:
    ended = subprocess.run(
        [sys.executable, "-c", _SCRIPT.format(name="llvmlite.binding.module")],
        capture_output=True,
        text=True,
    )
    assert (ended.returncode, ended.stdout) == (130, "before\n"), ended.stderr


def test_other_interrupt_ends_with_destructors() -> None:
    ended = subprocess.run(
        [sys.executable, "-c", _SCRIPT.format(name="cbdsl.runtime")], capture_output=True, text=True
    )
    assert ended.returncode == -6


@pytest.mark.parametrize(
    ("name", "expected"),
    [("numba.core.compiler", True), ("llvmlite", True), ("numbat", False), ("cbdsl.run", False)],
)
def test_is_of_compiler_finds_its_frames_in_the_causes_of_an_error(
    name: str, expected: bool
) -> None:
    held: dict[str, object] = {"__name__": name}
    exec("def compile_it():\n    raise KeyboardInterrupt", held)
    with pytest.raises(SystemExit) as ended:
        try:
            held["compile_it"]()  # type: ignore[operator]
        except KeyboardInterrupt:
            sys.exit(130)
    assert is_of_compiler(ended.value) is expected
    assert not is_of_compiler(None)


# An interrupt that a callback of the compiler loses, and its consequence.
_LOST = """
import sys
from cbdsl.cli import main as command

held = {"__name__": "llvmlite.binding", "sys": sys}
exec('''
class Callback:
    def __del__(self):
        raise KeyboardInterrupt

def link():
    callback = Callback()
    del callback
    raise RuntimeError("no compiled object yet")
''', held)

def app(*_, **__):
    return lambda words: held["link"]()

command.build_app = app
sys.argv = ["cb", "list"]
command.main()
"""


def test_error_of_the_compiler_after_a_lost_interrupt_is_an_interrupt() -> None:
    ended = subprocess.run([sys.executable, "-c", _LOST], capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (130, "")
