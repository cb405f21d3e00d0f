"""``cb fmt``: documents in one layout, with the same values and comments."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import unified_diff
from pathlib import Path
from typing import Annotated

import typer

from cbdsl.cli.arguments.chosen_files import STANDARD_INPUT, choose_files
from cbdsl.cli.arguments.options import Paths
from cbdsl.cli.output.terminal import print_diagnostics, print_line, print_problem
from cbdsl.cli.process.standard_streams import read_standard_input
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.diagnostics.legible_text import one_line
from cbdsl.documents.document import Document
from cbdsl.documents.ownership import is_declared
from cbdsl.documents.program import ProgramDocument
from cbdsl.storage.atomic_file import write_text
from cbdsl.yaml_text.composer import MOST_BYTES
from cbdsl.yaml_text.library import Library
from cbdsl.yaml_text.reader import decode, formatted_text, read, read_text

Check = Annotated[
    bool, typer.Option("--check", help="Write nothing; exit with 1 if a document would change.")
]
Diff = Annotated[bool, typer.Option("--diff", help="Write nothing; print the changes.")]

AsSteps = Annotated[
    bool, typer.Option("--steps", help="Also write policies over patterns of states as steps.")
]


def fmt(
    paths: Paths, *, check: Check = False, diff: Diff = False, as_steps: AsSteps = False
) -> None:
    """Format documents: uniform indentation and spacing, without superfluous empty lines.

    Values, their order, quotes and comments do not change. Files are replaced atomically, and
    changed files are listed. The standard input is printed. YAML of other tools stays unchanged: a
    document has the key 'cbdsl', or a 'kind' of this project.

    With --steps, a program gets steps with named exits in place of its policy. It decides each
    state in the same way as before.

    Exit 0 on success, 1 if --check found a change or a document is not valid YAML, 2 for wrong
    arguments.
    """
    if paths == [STANDARD_INPUT] and not (check or diff or as_steps):
        raise typer.Exit(_print_formatted())
    if STANDARD_INPUT in paths:
        raise UsageError("the standard input stands alone, without --check, --diff and --steps")
    changed, failed = 0, False
    for file in choose_files(paths, Path(STANDARD_INPUT), Library()).files:
        try:
            if file.is_symlink() and file not in map(Path, paths):
                continue  # it leads to a file that the user has not named
            is_named = not _is_below(file, paths)
            changed += _format(file, as_steps, check=check, diff=diff, is_named=is_named)
        except DiagnosticsError as error:
            print_diagnostics(error.diagnostics)
            failed = True
    raise typer.Exit(1 if failed or (check and changed) else 0)


def _is_below(file: Path, paths: Sequence[str]) -> bool:
    """Return whether a file was found in a folder among the paths, rather than named itself."""
    folders = [Path(path).resolve() for path in paths if Path(path).is_dir()]
    return any(file.resolve().is_relative_to(folder) for folder in folders)


def _print_formatted() -> int:
    """Format the standard input onto the standard output, and return the exit code."""
    file = Path("stdin.yaml")
    # One byte beyond the limit shows `decode` that the text is too long.
    text = decode(read_standard_input(MOST_BYTES + 1), str(file))
    print(_formatted(text, file, is_named=True), end="")
    return 0


def _format(file: Path, as_steps: bool, *, check: bool, diff: bool, is_named: bool) -> bool:
    """Format a file, and return whether it was, or would be, changed."""
    before = read_text(file)
    after = _formatted(before, file, is_named)
    if as_steps and is_declared(before):
        after = _with_steps(after, file)
    if after == before:
        return False
    if diff:
        _print_difference(file, before, after)
    elif not check:
        write_text(after, file, follow=True)
    print_line(f"{'would format' if check or diff else 'formatted'} {file}")
    return True


def _formatted(text: str, file: Path, is_named: bool) -> str:
    """Return a document's formatted text; other YAML stays, with a warning if the user named it."""
    if is_declared(text):
        return formatted_text(text, str(file))
    if is_named:
        print_problem(f"{file}: not formatted, since it lacks a document's keys 'cbdsl' and 'kind'")
    return text


def _with_steps(text: str, file: Path) -> str:
    from cbdsl.checking.program import check_program
    from cbdsl.checking.step_conversion import with_steps

    document = read(file, Document, text).document
    if not isinstance(document, ProgramDocument):
        return text
    return with_steps(text, document, check_program(file))


def _print_difference(file: Path, before: str, after: str) -> None:
    name = one_line(str(file))
    old, new = (text.splitlines(keepends=True) for text in (before, after))
    print("".join(unified_diff(old, new, name, name)), end="")
