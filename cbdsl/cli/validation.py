"""Check of documents and output of diagnostics, for ``cb validate``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from cbdsl.cli.arguments.chosen_files import STANDARD_INPUT, choose_files
from cbdsl.cli.process.standard_streams import read_standard_input

if TYPE_CHECKING:
    from cbdsl.diagnostics.diagnostic import Diagnostic
    from cbdsl.diagnostics.validation_report import ValidationReport
    from cbdsl.yaml_text.library import Library

#: Writer of each format: a module of ``cbdsl.diagnostics``, and its function of a report.
FORMATS = {
    "text": ("text_format", "text"),
    "json": ("json_format", "json_report"),
    "github": ("github_format", "github"),
    "sarif": ("sarif_format", "sarif"),
}
#: Name of the standard input unless another one is given.
STANDARD_INPUT_NAME = "stdin.yaml"

# Further diagnostics of one document usually have the same causes as the first ones.
_MOST_PER_FILE = 100


def check_paths(
    paths: Iterable[str],
    values: Mapping[str, str],
    form: str = "text",
    strict: bool = False,
    stdin_name: str = STANDARD_INPUT_NAME,
) -> int:
    """Check documents and folders of documents, and print the diagnostics.

    Notes state assumptions of a document. They are printed where it is chosen, and not with every
    document that uses it.

    Args:
        paths: Files and folders; ``-`` is the standard input.
        values: Values of programs' parameters by name.
        form: Format of the output, a key of ``FORMATS``.
        strict: True if warnings count as errors.
        stdin_name: File name of the standard input in diagnostics.

    Returns:
        Exit code: 0 without errors, 1 with errors, 2 if a check failed.

    Raises:
        UsageError: A folder holds no documents, or the format is unknown.
    """
    write = _writer(form)
    report = _examine(paths, values, Path(stdin_name))
    written = write(report)
    if written:
        print(written)
    return report.exit_code(strict)


def _writer(form: str) -> Callable[[ValidationReport], str]:
    from cbdsl.diagnostics.errors import UsageError

    if form not in FORMATS:
        raise UsageError.unknown("format", form, FORMATS)
    # Only the chosen writer is imported, because this command has to start quickly.
    module, function = FORMATS[form]
    writer: Callable[[ValidationReport], str] = getattr(
        import_module(f"cbdsl.diagnostics.{module}"), function
    )
    return writer


def _examine(paths: Iterable[str], values: Mapping[str, str], stdin: Path) -> ValidationReport:
    from cbdsl.checking.safety_net import check_safely
    from cbdsl.checking.session import Session
    from cbdsl.checking.suppression import apply_suppressions
    from cbdsl.cli.output.terminal import print_problem
    from cbdsl.diagnostics.validation_report import ValidationReport
    from cbdsl.documents.kinds import KINDS, entry_of
    from cbdsl.yaml_text.composer import MOST_BYTES
    from cbdsl.yaml_text.library import Library

    words = list(paths)
    # One byte beyond the limit shows the reader that the text is too long.
    given = {stdin: read_standard_input(MOST_BYTES + 1)} if STANDARD_INPUT in words else {}
    library = Library(given=given)
    chosen = choose_files(words, stdin, library)
    files = chosen.files
    session = Session(library, values)
    # A robot's diagnostics come with every program on it: each is reported once.
    every: dict[Diagnostic, None] = {}
    for file in files:
        every.update(dict.fromkeys(check_safely(file, session)))
    diagnostics = apply_suppressions(every, files, session.library)
    for fault in KINDS.met_faults:
        print_problem(f"warning: {fault}")
    shown = _first_of_each_file(diagnostics)
    return ValidationReport(
        shown,
        len(files),
        len(diagnostics) - len(shown),
        _texts(session.library),
        chosen.others,
        chosen.unreadable,
        entry_of,
    ).without_notes_elsewhere({str(file) for file in files})


def _first_of_each_file(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    counts: Counter[str] = Counter()
    first = []
    for diagnostic in diagnostics:
        counts[diagnostic.place.file] += 1
        if counts[diagnostic.place.file] <= _MOST_PER_FILE:
            first.append(diagnostic)
    return tuple(first)


def _texts(library: Library) -> Callable[[str], str | None]:
    """Return a cached function of a file that returns its text for snippets, or ``None``."""
    from cbdsl.diagnostics.errors import DiagnosticsError

    @cache
    def text_of(file: str) -> str | None:
        try:
            return library.text(Path(file))
        except DiagnosticsError:
            return None

    return text_of
