"""``cb validate --fix``: corrections of misspelled names, written to the files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from cbdsl.checking.safety_net import check_safely
from cbdsl.checking.session import Session
from cbdsl.cli.arguments.chosen_files import STANDARD_INPUT, choose_files
from cbdsl.cli.output.terminal import print_problem
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.editor.fixes import fixed
from cbdsl.storage.atomic_file import write_text
from cbdsl.yaml_text.library import Library

# The correction of one name may reveal another misspelled name.
_ROUNDS = 5


def fix_paths(paths: Iterable[str], values: Mapping[str, str]) -> None:
    """Replace unknown names by their nearest names, in documents and folders of documents.

    The changed files are written atomically and listed on the standard error.

    Args:
        paths: Files and folders.
        values: Values of programs' parameters by name.

    Raises:
        UsageError: A path is the standard input, or a folder holds no documents.
    """
    words = list(paths)
    if STANDARD_INPUT in words:
        raise UsageError("--fix writes files; the standard input is none")
    changed: dict[Path, None] = {}
    for _ in range(_ROUNDS):
        now = _fix_once(words, values)
        changed.update(dict.fromkeys(now))
        if not now:
            break
    for path in changed:
        print_problem(f"fixed {path}")


def _fix_once(words: Sequence[str], values: Mapping[str, str]) -> list[Path]:
    """Correct each file once, and return the changed files."""
    # A new library in each round reads the texts that the round before has written.
    library, changed = Library(), []
    session = Session(library, values)
    for file in choose_files(words, Path(STANDARD_INPUT), library).files:
        # Diagnostics in other documents are corrected only if these are named as well.
        own = [each for each in check_safely(file, session) if each.place.file == str(file)]
        try:
            before = library.text(file)
        except DiagnosticsError:
            continue
        after = fixed(before, own)
        # A link in a folder leads to a file that the user has not named.
        is_named = file in map(Path, words)
        if after != before and (is_named or not file.is_symlink()):
            write_text(after, file, follow=is_named)
            changed.append(file)
    return changed
