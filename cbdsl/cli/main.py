"""Command ``cb``."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from itertools import pairwise
from time import sleep
from traceback import walk_tb
from typing import TYPE_CHECKING, NoReturn

from cbdsl.cli.process.legible_output import legible_output
from cbdsl.cli.process.standard_streams import fill_closed_streams
from cbdsl.diagnostics.errors import UsageError
from cbdsl.numeric.numba_settings import ignore_settings_of_folder

if TYPE_CHECKING:
    import typer

    from cbdsl.diagnostics.diagnostic import Diagnostic


# Shells report 128 plus the number of the signal; SIGINT is 2.
_INTERRUPTED = 130


def build_app(names: Iterable[str] = (), *, lists: bool = False) -> typer.Typer:
    """Return the command line with some of its commands, or with all usable ones.

    Args:
        names: Names of the commands; empty for all.
        lists: True if the app only lists its commands, so that they are not imported.
    """
    import typer

    from cbdsl.cli.commands import COMMANDS, add_command, add_summary, main_names
    from cbdsl.cli.version import options

    app = typer.Typer(
        help="Declare, check and run robot behaviour as data.",
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )
    # With options of its own, cb keeps a command's name when that is the only one.
    app.callback(help=app.info.help)(options)
    for name in names or main_names():
        if lists:
            add_summary(app, name)
        else:
            add_command(app, name, COMMANDS.get(name))
    return app


def main() -> None:
    """Run ``cb``: exit 0 when all is well, 1 with diagnostics, 2 for a wrong call or a bug."""
    _start_quickly()
    # Before any file is opened, which could otherwise get the number of a closed stream.
    fill_closed_streams()
    sys.unraisablehook = lost = _LostInterrupts()
    try:
        with legible_output():
            _run(sys.argv[1:], lost)
    except SystemExit as end:
        if end.code == _INTERRUPTED and is_of_compiler(end):
            leave(_INTERRUPTED)
        raise


def _run(words: list[str], lost: _LostInterrupts) -> None:
    try:
        require_words(words)
        if asks_for_backends(words):
            words = ["show", "backends"]
        if _plain_validation(words):
            from cbdsl.cli.validation import check_paths

            sys.exit(check_paths(words[1:], {}))
        ignore_settings_of_folder()
        build_app(_requested(words), lists=_only_lists(words))(words)
    except KeyboardInterrupt as interrupt:
        _report_notes(interrupt)
        sys.exit(_INTERRUPTED)
    except BrokenPipeError:
        # The reader has closed the pipe; nothing may be flushed at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception as error:
        if lost.happened:
            _await_lost_interrupt(error)
        code = 2
        with suppress(BrokenPipeError):
            code = _report(error)
            _report_notes(error)
        sys.exit(code)
    finally:
        gc.freeze()  # a last search for garbage would only delay the exit


def _requested(words: list[str]) -> list[str]:
    """Return the command of the words; empty if they name none, so that all are listed.

    Building only the requested command saves a twentieth of its time.

    Raises:
        UsageError: The command belongs to a package that is not installed.
    """
    from cbdsl.cli.commands import COMMANDS

    if words and words[0] in COMMANDS and "." not in words[0]:
        return words[:1]
    if message := COMMANDS.missing().get(words[0]) if words else None:
        raise UsageError(message)
    from cbdsl.cli.output.terminal import warn_of_faults

    warn_of_faults(COMMANDS)
    return []


def _only_lists(words: list[str]) -> bool:
    """Return whether the words ask for the list of commands, and no shell for completions."""
    return words in ([], ["--help"]) and "_CB_COMPLETE" not in os.environ


def _plain_validation(words: list[str]) -> bool:
    """Return whether the words are ``validate`` and paths, the frequent call of editors and CI.

    This call needs no parser of options, whose import would take a tenth of the time.
    """
    return words[:1] == ["validate"] and len(words) > 1 and not any(w[:1] == "-" for w in words)


def _start_quickly() -> None:
    """Skip start-up work that short commands do not need."""
    # Imports create many objects and no garbage; collection takes a twentieth of cb validate.
    gc.set_threshold(100_000)
    # Else pydantic reads the metadata of every installed package.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "1")


class _LostInterrupts:
    """Hook that raises an interrupt again that Python raised where it cannot propagate.

    Such places are destructors and callbacks of C; numba has thousands of them while it loads
    machine code. There, Python would print Ctrl-C as ignored, and the command would continue.

    Attributes:
        happened: True after an interrupt was lost.
    """

    def __init__(self) -> None:
        self.happened = False
        self._report = sys.unraisablehook

    def __call__(self, lost: sys.UnraisableHookArgs) -> None:
        """Raise a lost interrupt again, and report all other exceptions."""
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            self._report(lost)
            return
        self.happened = True
        from _thread import interrupt_main
        from threading import Timer

        again = Timer(0.01, interrupt_main)  # without delay it would be lost in this hook
        again.daemon = True
        again.start()


def _await_lost_interrupt(error: Exception) -> None:
    """End the command if the compiler failed because an interrupt in one of its callbacks was lost.

    Such a callback stores machine code, which the compiler then misses.
    """
    if is_of_compiler(error):
        with suppress(KeyboardInterrupt):
            sleep(1.0)  # until it is raised again
        sys.exit(_INTERRUPTED)


def _report_notes(error: BaseException | None) -> None:
    """Print further failures beside an error, such as the halt of a robot."""
    from cbdsl.cli.output.terminal import print_problem

    # A `UsageError` often has no notes itself, but wraps the error that has them.
    while error is not None:
        for note in getattr(error, "__notes__", ()):
            print_problem(f"warning: {note}")
        error = error.__cause__


def _unsuppressed(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the errors, and the warnings that no comment suppresses."""
    from cbdsl.checking.suppression import apply_suppressions
    from cbdsl.diagnostics.diagnostic import Severity
    from cbdsl.yaml_text.library import Library

    given = list(diagnostics)
    left = apply_suppressions(given, [], Library())
    kept = [diagnostic for diagnostic in left if diagnostic.severity is not Severity.NOTE]
    return [diagnostic for diagnostic in given if diagnostic.is_error or diagnostic in kept]


def _report(error: Exception) -> int:
    """Print an error without a traceback, and return the exit code."""
    from cbdsl.cli.output.terminal import print_diagnostics, print_problem
    from cbdsl.diagnostics.errors import DiagnosticsError
    from cbdsl.diagnostics.reason import reason

    if isinstance(error, DiagnosticsError):
        print_diagnostics(_unsuppressed(error.diagnostics))
        return 1
    if isinstance(error, UsageError):
        print_problem(str(error))
        return 2
    if os.environ.get("CB_TRACEBACK"):
        raise error
    if isinstance(error, OSError):
        print_problem(f"{error.filename}: {reason(error)}" if error.filename else reason(error))
        return 2
    print_problem(f"internal error: {type(error).__name__}: {error}")
    print_problem("CB_TRACEBACK=1 shows where; please report it")
    return 2


_HELP = ("--help", "-h", "help")


def asks_for_backends(words: Sequence[str]) -> bool:
    """Return whether a word for help stands in place of a backend: ``--backend --help``.

    Args:
        words: Command-line words after ``cb``.

    Raises:
        UsageError: ``--backend`` is the last word and has no name.
    """
    if words[-1:] == ["--backend"]:
        raise UsageError(f"--backend is given no name (known: {', '.join(_backends())})")
    # Without this case, `--help` would be an unknown backend.
    pairs = pairwise(words)
    return any(before == "--backend" and word in _HELP for before, word in pairs)


def _backends() -> Sequence[str]:
    """Return the names of all backends."""
    from cbdsl.cli.episodes.simulation import needing_simulation

    with needing_simulation():
        from cbdsl.backends.backend import BACKENDS
    return BACKENDS.names()


def require_words(words: Sequence[str]) -> None:
    """Reject an empty word, which is most often an unset variable of a shell.

    An empty path would be the working folder, and an empty name the default.

    Args:
        words: Command-line words after ``cb``.

    Raises:
        UsageError: A word is empty, or the text of an option after ``=`` is.
    """
    for before, word in zip(["cb", *words], words, strict=False):
        option, equals, text = word.partition("=")
        if option.startswith("--") and equals and not text:
            raise UsageError(f"{option} is given an empty text")
        # `cb run "$PROGRAM"` reaches this with an unset variable.
        if not word:
            place = f"{before} is given" if before.startswith("--") else f"after '{before}' stands"
            raise UsageError(f"{place} an empty text")


_COMPILER = ("numba", "llvmlite")


# The compiler passes the ownership of modules to LLVM in two steps: a call of C, and a note in the
# Python object. An interrupt between the two leaves a module with two owners. The destructor of the
# object then frees it a second time, and the process ends by SIGABRT or SIGSEGV. The exception
# keeps the object alive as long as it is handled, so that the process has to end meanwhile.
def is_of_compiler(error: BaseException | None) -> bool:
    """Return whether an error, or an error that led to it, was raised within the compiler."""
    while error is not None:
        for frame, _ in walk_tb(error.__traceback__):
            if frame.f_globals.get("__name__", "").partition(".")[0] in _COMPILER:
                return True
        error = error.__cause__ or error.__context__
    return False


def leave(code: int) -> NoReturn:
    """End the process without the destructors of its objects."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)
