"""Repair of faulty texts: the single entry point to all corrections."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby, islice
from pathlib import Path
from typing import TypeVar

from cbdsl.diagnostics.diagnostic import Diagnostic, Place
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.lines import lines_of
from cbdsl.diagnostics.wording import diagnose
from cbdsl.documents.document import Document
from cbdsl.documents.kinds import kind_name
from cbdsl.yaml_text.characters import invisible_in, without_invisible
from cbdsl.yaml_text.composer import (
    Composed,
    YamlSyntaxError,
    compose,
    require_readable,
    require_short_lines,
    unseen,
)
from cbdsl.yaml_text.loaded import Invalid, Loaded
from cbdsl.yaml_text.repair.kind_identification import identify
from cbdsl.yaml_text.repair.salvage import salvage
from cbdsl.yaml_text.repair.syntax import find_correction
from cbdsl.yaml_text.source_map import SourceMap

D = TypeVar("D", bound=Document)


def repair(
    path: Path,
    kind: type[D],
    text: str,
    composed: Composed | None = None,
    invalid: Invalid | None = None,
) -> Loaded[D]:
    """Return the sound parts of a document of one kind, with all faults of its text.

    Args:
        path: File of the document.
        kind: Required kind of document.
        text: Text of the file.
        composed: Nodes of the text, if they are already composed.
        invalid: Errors of these nodes, if they are already validated.

    Raises:
        DiagnosticsError: No part of the document can be checked.
    """
    composed = mend(text, str(path), composed)
    source = SourceMap(path, composed.lines, composed.root)
    _require_version(source)
    model, diagnostics = identify(source, composed.diagnostics)
    if not issubclass(model, kind):
        place, given = source.place("kind"), str(source.node(("kind",)).value)
        wrong = diagnose("CB201", place, wanted=kind_name(kind), found=given)
        raise DiagnosticsError([wrong])
    is_validated = invalid is not None and invalid.model is model and not diagnostics
    errors = invalid.errors if invalid is not None and is_validated else ()
    return salvage(source, model, diagnostics, errors)


def _require_version(source: SourceMap) -> None:
    """Refuse a later version of the language, whose keys may have other meanings.

    Raises:
        DiagnosticsError: The document declares a later version.
    """
    root = source.root.value
    version = root.get("cbdsl") if isinstance(root, dict) else None
    if version is not None and isinstance(version.value, int) and version.value > 1:
        raise DiagnosticsError([diagnose("CB240", version.place, version=version.value)])


# Further mistakes in a text are found once these are corrected.
_MOST_CORRECTIONS = 10


def mend(text: str, file: str, known: Composed | None = None) -> Composed:
    """Compose the single document of a text, with mistakes corrected; lines keep their numbers.

    Args:
        text: Text as written.
        file: Name of the file in diagnostics.
        known: Nodes of the text as written, if they are already composed.

    Raises:
        DiagnosticsError: A fatal diagnostic, together with all diagnostics up to it.
    """
    require_readable(text, file)
    given, (text, diagnostics) = text, _legible(text, file)
    if known is not None and text == given:
        return known._replace(diagnostics=(*diagnostics, *known.diagnostics))
    # Each round adds a diagnostic, and their number is bounded, so that the loop ends even if
    # corrections do not help.
    while True:
        try:
            composed = compose(text, file)
        except YamlSyntaxError as fault:
            require_short_lines(text, file)
            correction = find_correction(fault.error, lines_of(text))
            place = Place(file, correction.line, correction.column, correction.column + 1)
            diagnostics.append(diagnose(correction.code, place, problem=correction.problem))
            if not correction.lines or len(diagnostics) >= _MOST_CORRECTIONS:
                raise DiagnosticsError([*diagnostics, *fault.diagnostics]) from None
            text = "\n".join(correction.mended(lines_of(text)))
        except DiagnosticsError as error:
            raise DiagnosticsError([*diagnostics, *error.diagnostics]) from None
        else:
            return composed._replace(diagnostics=(*diagnostics, *composed.diagnostics))


def _legible(text: str, file: str) -> tuple[str, list[Diagnostic]]:
    """Return a text without invisible characters and conflicts, and the diagnostics about these."""
    diagnostics = []
    if invisible := invisible_in(text):
        # One diagnostic represents all: invisible characters tend to occur in large numbers.
        diagnostics.append(unseen("CB118", invisible, file))
        text = without_invisible(text)
    lines = lines_of(text)
    diagnostics += islice(conflicts(lines, file), _MOST_CORRECTIONS)
    return "\n".join(one_side(lines)), diagnostics


# If git cannot merge two versions, it writes both between markers. A diff writes ``-`` in front of
# old lines and ``+`` in front of new lines.

_MARKER = re.compile(r"(?:<{7}|\|{7}|>{7})(?: .*)?\Z|={7}\Z")
_FIRST, _LAST = "<<<<<<<", ">>>>>>>"
_MERGED = (
    "belongs to a merge conflict; keep one of the two sides, and delete the lines that begin with "
    "'<<<<<<<', '=======' and '>>>>>>>'"
)
_COMPARED = (
    "belongs to a diff of two versions; keep the lines that begin with '+', without the sign, and "
    "delete the lines that begin with '-', or vice versa"
)
# A line of the newer version has a plus sign in front of a key or an item.
_NEWER = re.compile(r"\+\s*(?:- \s*\S|[\w*'\"-]+\s*:(?:\s|$))")


def conflicts(lines: list[str], file: str) -> Iterator[Diagnostic]:
    """Yield one diagnostic for each conflict or diff, and for each stray marker."""
    is_inside = False
    for number, line in enumerate(lines, 1):
        if not _is_marker(line):
            continue
        mark = line[:7]
        # The first marker of a conflict represents it. A marker outside of a conflict is reported
        # by itself.
        if mark == _FIRST or not is_inside:
            yield diagnose("CB122", Place(file, number, 1, 8), problem=f"'{mark}' {_MERGED}")
        is_inside = mark == _FIRST or (is_inside and mark != _LAST)
    for number, *_ in _comparisons(lines):
        mark = lines[number - 1][0]
        yield diagnose("CB122", Place(file, number, 1, 2), problem=f"'{mark}' {_COMPARED}")


def one_side(lines: list[str]) -> list[str]:
    """Return the first side of each conflict and the newer version of each diff.

    Every line keeps its number.
    """
    kept, is_inside, is_other = [], False, False
    for line in lines:
        is_mark = _is_marker(line)
        if is_mark:
            is_inside = line[:7] == _FIRST or (is_inside and line[:7] != _LAST)
            is_other = is_inside and line[:7] != _FIRST
        kept.append("" if is_mark or is_other else line)
    for number in (number for run in _comparisons(kept) for number in run):
        line = kept[number - 1]
        kept[number - 1] = line[1:] if line[0] == "+" else ""
    return kept


def _is_marker(line: str) -> bool:
    return line[:1] in ("<", "|", "=", ">") and _MARKER.match(line) is not None


def _comparisons(lines: list[str]) -> Iterator[list[int]]:
    """Yield the line numbers of each run of lines that begin with the signs of a diff."""
    for is_signed, run in groupby(enumerate(lines, 1), lambda row: row[1][:1] in ("+", "-")):
        numbered = list(run) if is_signed else []
        # Lines that begin with "-" alone are usually the items of a list.
        if any(_NEWER.match(line) for _, line in numbered):
            yield [number for number, _ in numbered]
