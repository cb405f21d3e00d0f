"""Options of a command for the inputs of a request."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import MISSING, Field, fields
from typing import Annotated, Any, get_args

import typer

from cbdsl.api.requests.declaration import default_of
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.options import BodyNumber, Cameras, Program, Resume, Seed, Set, With
from cbdsl.cli.episodes.simulation import BackendName

# Options that commands share, by the names of their inputs.
_SHARED: Mapping[str, Any] = {
    "program": Program,
    "seed": Seed,
    "backend": BackendName,
    "cameras": Cameras,
    "body": BodyNumber,
    "resume": Resume,
    "constants": Set,
    "values": With,
}


def is_request(group: Any) -> bool:
    """Return whether a dataclass declares the inputs of a verb."""
    return all("text" in each.metadata for each in fields(group))


def request_options(request: Any) -> Iterator[inspect.Parameter]:
    """Yield the options of a request as parameters of a command."""
    for each in fields(request):
        if "kind" not in each.metadata["option"] and each.name not in _SHARED:
            continue
        default = default_of(each)
        if each.name == "backend" or default is MISSING:
            default = inspect.Parameter.empty
        elif each.default_factory is not MISSING:
            default = []  # of assignments
        kind = inspect.Parameter.KEYWORD_ONLY
        yield inspect.Parameter(each.name, kind, default=default, annotation=_annotation(each))


def read_request_options(words: Mapping[str, Any]) -> dict[str, Any]:
    """Return the inputs of a request from the words of a command.

    Raises:
        UsageError: A word is no assignment.
    """
    inputs = dict(words)
    for name, flag in (("constants", "--set"), ("values", "--with")):
        if name in inputs:
            inputs[name] = read_assignments(inputs[name], flag)
    return inputs


def _annotation(field: Field[Any]) -> Any:
    """Return the type of an input on the command line, with its option."""
    settings = dict(field.metadata["option"])
    group = settings.pop("group", None)
    if "kind" not in settings:
        kind, option = get_args(_SHARED[field.name])
        option = copy(option)  # others have the same option in another group, or in none
    else:
        kind, flag = settings.pop("kind"), settings.pop("flag", "")
        help = settings.pop("help", field.metadata["text"].replace("``", ""))
        if flag == "-":
            option = typer.Argument(help=help, **settings)
        else:
            flag = flag or f"--{field.name.replace('_', '-')}"
            option = typer.Option(flag, help=help, **settings)
    option.rich_help_panel = group
    return Annotated[kind, option]
