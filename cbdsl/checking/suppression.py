"""Suppression of diagnostics by comments, and diagnostics on such comments."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cbdsl.diagnostics.diagnostic import Diagnostic
    from cbdsl.yaml_text.ignores import Ignore
    from cbdsl.yaml_text.library import Library


def apply_suppressions(
    diagnostics: Collection[Diagnostic], files: Iterable[Path], library: Library
) -> list[Diagnostic]:
    """Remove suppressed diagnostics and add those of the suppressions, causes first.

    Args:
        diagnostics: Diagnostics of the files and of the files that they refer to.
        files: Files checked by themselves; only their suppressions are reported as unused.
        library: Library with the texts of all files.
    """
    from cbdsl.checking.cause_order import causes_first

    # The same file may have been read by a shorter path before.
    own = {library.real(file): file for file in files}
    places = (Path(diagnostic.place.file) for diagnostic in diagnostics)
    texts = {**{library.real(path): path for path in places}, **own}
    ignores = {file: _ignores(path, library) for file, path in texts.items()}
    # A suppression applies to one code on one line. The resolved file is part of the key, because
    # one file may have several paths.
    silencing = {
        (file, ignore.line, ignore.code): ignore
        for file, all_ in ignores.items()
        for ignore in all_
    }
    kept, hits = [], set()
    for diagnostic in diagnostics:
        place = diagnostic.place
        ignore = silencing.get((library.real(Path(place.file)), place.line, diagnostic.code))
        if ignore is None:
            kept.append(diagnostic)
        else:
            hits.add(ignore)
    faults = [fault for file in own for ignore in ignores[file] for fault in _faults(ignore, hits)]
    return causes_first([*kept, *faults], library)


def _ignores(path: Path, library: Library) -> list[Ignore]:
    from cbdsl.diagnostics.errors import DiagnosticsError

    try:
        text = library.text(path)
    except DiagnosticsError:
        return []  # the unreadable file has a diagnostic already
    # Most texts have no such comment; this test avoids the parser.
    if "cb: ignore" not in text:
        return []
    from cbdsl.yaml_text.ignores import read_ignores

    return read_ignores(text, str(path))


def _faults(ignore: Ignore, hits: set[Ignore]) -> Iterator[Diagnostic]:
    from cbdsl.diagnostics.wording import diagnose
    from cbdsl.documents.kinds import entry_of

    if entry_of(ignore.code) is None:
        yield diagnose("CB803", ignore.place, name=ignore.code)
        return
    if ignore not in hits:
        yield diagnose("CB801", ignore.place, ignored=ignore.code)
    if not ignore.reason:
        yield diagnose("CB802", ignore.place, ignored=ignore.code)
