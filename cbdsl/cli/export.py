"""``cb export``: programs and recordings in formats of other tools."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from inspect import Parameter, getdoc, signature
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, get_type_hints

import typer

from cbdsl.cli.arguments.options import Recording
from cbdsl.cli.command_group import CommandGroup
from cbdsl.cli.commands import Command, commands_of
from cbdsl.cli.output.terminal import print_line
from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.legible_text import one_line
from cbdsl.diagnostics.reason import reason
from cbdsl.reporting.export_format import EXPORTS, Export
from cbdsl.storage.atomic_file import require_unlinked


def _formats() -> Iterator[tuple[str, Callable[[], Command]]]:
    """Yield the names of formats, and functions that return their commands."""
    yield from commands_of("export")
    for name in (*EXPORTS.names(), *EXPORTS.missing()):
        yield name, partial(_command, name)


export = CommandGroup(_formats, "Write programs and recordings in formats of other tools.")


def _command(name: str) -> Callable[..., None]:
    """Return the command of a format, whose options are those of its function."""
    form = EXPORTS.get(name)

    def command(recording: Path, out: Path | None, **options: Any) -> None:
        for key, value in options.items():
            if isinstance(value, str):
                options[key] = one_line(value)
        with _needed(name):
            _export(form, recording, out, options)

    place = f"Folder to write [{form.folder}, beside the recordings]."
    if form.suffix:
        place = f"File to write [beside the recording, {form.suffix}]."
    out = Annotated[Path | None, typer.Option("--out", help=place)]
    kind = Parameter.POSITIONAL_OR_KEYWORD
    command.__signature__ = signature(command).replace(  # type: ignore[attr-defined]
        parameters=[
            Parameter("recording", kind, annotation=Recording),
            Parameter("out", kind, annotation=out, default=None),
            *_options(name, form),
        ]
    )
    command.__annotations__ = {}
    command.__doc__ = getdoc(form.write)
    return command


def _options(name: str, form: Export) -> list[Parameter]:
    """Return the keyword-only parameters of a format's function, with their types."""
    own = signature(form.write).parameters.values()
    options = {each.name: each for each in own if each.kind is Parameter.KEYWORD_ONLY}
    texts = SimpleNamespace(__annotations__={key: options[key].annotation for key in options})
    try:
        # Other parameters may have types that are imported for type checkers only.
        types = get_type_hints(texts, form.write.__globals__, include_extras=True)
    except NameError as error:
        raise EXPORTS.fault(name, f"has an option without a type at run time: {error}") from error
    return [option.replace(annotation=types[key]) for key, option in options.items()]


def _export(form: Export, place: Path, out: Path | None, options: dict[str, Any]) -> None:
    """Write recordings in a format, and print the contents of each target."""
    from cbdsl.reporting.recorded import find_recordings, read_recording

    files = find_recordings(place)
    if form.folder:
        _write(form, map(read_recording, files), out or files[0].parent / form.folder, options, out)
        return
    if out is not None and len(files) > 1:
        raise UsageError(f"--out {out}: {place} holds {len(files)} recordings; name one of them")
    for file in files:
        # Read before the target is named; errors of reading name the recording.
        recorded = read_recording(file)
        _write(form, [recorded], out or file.with_suffix(form.suffix), options, out)


def _write(
    form: Export,
    recordings: Iterable[Any],
    target: Path,
    options: dict[str, Any],
    named: Path | None,
) -> None:
    try:
        if named is None:
            require_unlinked(target)
        contents = form.write(recordings, target, **options)
    except OSError as error:
        raise UsageError(f"{target}: {reason(error)}") from error
    print_line(f"{target}: {contents}")


@contextmanager
def _needed(name: str) -> Iterator[None]:
    """Name the export if a module is missing.

    Raises:
        UsageError: A module is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise UsageError(
            f"export '{name}' ({EXPORTS.package(name)}) needs {error.name}, which is not installed"
        ) from error
