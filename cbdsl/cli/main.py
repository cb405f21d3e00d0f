"""The command ``cb``."""

from __future__ import annotations

import os
import sys

import typer

from cbdsl.cli import show
from cbdsl.cli.explain import explain
from cbdsl.cli.run import run
from cbdsl.cli.validate import validate

app = typer.Typer(
    help="Declare, check and run robot behaviour as data.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.command("validate")(validate)
app.command("run")(run)
app.command("explain")(explain)
app.add_typer(show.app, name="show")


def main() -> None:
    """Run ``cb``: exit 0 when all is well, 1 with findings, 2 for a wrong call or a fault of cb."""
    try:
        app()
    except KeyboardInterrupt:
        sys.exit(130)
    except BrokenPipeError:
        # Whoever read the output has seen enough; nothing may be flushed at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception as error:
        sys.exit(_report(error))


def _report(error: Exception) -> int:
    """Tell what went wrong, without a traceback; the exit code."""
    from cbdsl.cli.terminal import print_diagnostics, print_problem
    from cbdsl.errors.errors import DiagnosticsError, UsageError

    if isinstance(error, DiagnosticsError):
        print_diagnostics(error.diagnostics)
        return 1
    if isinstance(error, UsageError):
        print_problem(str(error))
        return 2
    if os.environ.get("CB_TRACEBACK"):
        raise error
    print_problem(f"internal error: {type(error).__name__}: {error}")
    print_problem("CB_TRACEBACK=1 shows where; please report it")
    return 2
