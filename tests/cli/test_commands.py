"""Commands of ``cb``: their list, which imports none of them."""

from __future__ import annotations

import subprocess
import sys

import typer
from typer.testing import CliRunner

from cbdsl.cli.commands import COMMANDS, GROUPS, SUMMARIES
from cbdsl.cli.main import build_app


def test_list_of_commands_equals_the_help_of_all_commands() -> None:
    listed, whole = (
        CliRunner().invoke(build_app(lists=lists), ["--help"]).output for lists in (True, False)
    )
    assert "calibrate" in listed and listed == whole


def test_groups_are_the_commands_with_commands_of_their_own() -> None:
    groups = [name for name in SUMMARIES if isinstance(COMMANDS.get(name), typer.Typer)]
    assert sorted(groups) == sorted(GROUPS)


def test_help_imports_no_builtin_command() -> None:
    code = (
        "import sys; from cbdsl.cli.main import main\n"
        "sys.argv = ['cb', '--help']\n"
        "try: main()\n"
        "finally: print(*sorted(m for m in sys.modules if m.startswith('cbdsl.')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.splitlines()[-1].split())
    assert "cbdsl.cli.main" in loaded
    assert loaded.isdisjoint({f"cbdsl.cli.{name}" for name in SUMMARIES} - {"cbdsl.cli.show"})
    assert "cbdsl.documents.document" not in loaded
