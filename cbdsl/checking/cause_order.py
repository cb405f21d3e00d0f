"""Order of diagnostics: possible causes come first."""

from __future__ import annotations

from collections.abc import Iterable
from operator import attrgetter
from pathlib import Path

from cbdsl.diagnostics.diagnostic import Diagnostic
from cbdsl.yaml_text.library import Library


def causes_first(diagnostics: Iterable[Diagnostic], library: Library) -> list[Diagnostic]:
    """Return diagnostics with the documents that others depend on before their dependents.

    Independent documents keep the order of their paths, and the diagnostics of a document the
    order of its lines.

    Args:
        diagnostics: Diagnostics in any documents.
        library: Library with the references between these documents.
    """
    by_file: dict[Path, list[Diagnostic]] = {}
    for diagnostic in sorted(diagnostics, key=attrgetter("place", "code")):
        by_file.setdefault(library.real(Path(diagnostic.place.file)), []).append(diagnostic)
    if len(by_file) < 2:
        return [diagnostic for some in by_file.values() for diagnostic in some]
    return [
        diagnostic
        for file in _named_first(by_file, library)
        for diagnostic in by_file.get(file, ())
    ]


def _named_first(files: Iterable[Path], library: Library) -> Iterable[Path]:
    """Return files and all files that they name, directly or not, each after the files it names."""
    # Depth-first search in postorder: a file is done after all files that it names. An explicit
    # stack allows chains of any length. A file that is met again within a circle is not entered
    # twice.
    done: dict[Path, None] = {}
    entered: set[Path] = set()
    waiting = list(files)[::-1]
    while waiting:
        file = waiting[-1]
        if file in entered:
            done.setdefault(waiting.pop())
            continue
        entered.add(file)
        waiting.extend(sorted(library.named_in(file) - entered, reverse=True))
    return done
