"""Groups of options: one parameter of a command for several words of the command line."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from copy import copy
from dataclasses import MISSING, Field, fields, is_dataclass
from itertools import groupby
from typing import Annotated, Any, get_args, get_type_hints

import typer
from typer.core import TyperCommand

from cbdsl.api.requests.declaration import default_of
from cbdsl.cli.arguments.assignments import read_assignments
from cbdsl.cli.arguments.completion import names_of
from cbdsl.cli.arguments.options import (
    BackendName,
    BodyNumber,
    Cameras,
    Program,
    Resume,
    Seed,
    Set,
    With,
)


class GroupedCommand(TyperCommand):
    """Command whose help lists the options of each group below the name of the group."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments, options without a group, and the groups in their order."""

        def section(parameter: Any) -> str:
            is_argument = parameter.param_type_name == "argument"
            panel = getattr(parameter, "rich_help_panel", None)
            return panel or ("Arguments" if is_argument else "Options")

        parameters = self.get_params(ctx)
        # Single options come first, and --help with them; the sort keeps the other orders.
        first = {"Arguments": -2, "Options": -1}
        places = {section(each): i for i, each in enumerate(parameters)} | first
        ordered = sorted(parameters, key=lambda each: places[section(each)])
        for name, members in groupby(ordered, section):
            records = [record for each in members if (record := each.get_help_record(ctx))]
            if records:
                with formatter.section(name):
                    formatter.write_dl(records)


def heading(group: type) -> str:
    """Return the heading of a group, such as "Trial options" for ``TrialOptions``."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", group.__name__).capitalize()


# Typer derives options from the signature of a command. A parameter whose type is a dataclass is a
# group, or the request of a verb: its fields, annotated as options or declared as inputs, take its
# place in the signature that Typer reads. The command receives the group or the request.
def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with an option for each field of its groups and requests."""
    signature = inspect.signature(command, eval_str=True)
    groups: dict[str, Any] = {
        name: parameter.annotation
        for name, parameter in signature.parameters.items()
        if is_dataclass(parameter.annotation)
    }

    options = {name: [*_options(group)] for name, group in groups.items()}

    def flat(**given: Any) -> None:
        filled = {}
        for name, group in groups.items():
            words = {each.name: given.pop(each.name) for each in options[name]}
            filled[name] = group(**read_request_options(words))
        command(**given, **filled)

    parameters = [
        option
        for name, parameter in signature.parameters.items()
        for option in options.get(name, (parameter,))
    ]
    for name in ("__name__", "__doc__", "__module__"):
        setattr(flat, name, getattr(command, name))
    flat.__annotations__ = {each.name: each.annotation for each in parameters}
    flat.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return flat


def _options(group: Any) -> Iterator[inspect.Parameter]:
    """Yield the options of a group as keyword parameters."""
    if is_request(group):
        yield from request_options(group)
        return
    yield from request_options(group, heading(group))
    annotations = get_type_hints(group, include_extras=True)
    for field in fields(group):
        if "text" in field.metadata:
            continue
        default = default_of(field)
        default = inspect.Parameter.empty if default is MISSING else default
        kind, annotation = inspect.Parameter.KEYWORD_ONLY, annotations[field.name]
        kept, option = get_args(annotation)
        option = copy(option)  # others may have the same option in another group, or in none
        option.rich_help_panel = heading(group)
        yield inspect.Parameter(
            field.name, kind, default=default, annotation=Annotated[kept, option]
        )


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


def request_options(request: Any, panel: str | None = None) -> Iterator[inspect.Parameter]:
    """Yield the options of declared inputs as parameters of a command.

    Args:
        request: Request, or group with declared inputs.
        panel: Heading of inputs that declare none.
    """
    for each in fields(request):
        if "text" not in each.metadata:
            continue
        if "kind" not in each.metadata["option"] and each.name not in _SHARED:
            continue
        default = default_of(each)
        if each.name == "backend" or default is MISSING:
            default = inspect.Parameter.empty
        elif each.default_factory is not MISSING:
            default = []  # of assignments
        kind = inspect.Parameter.KEYWORD_ONLY
        yield inspect.Parameter(
            each.name, kind, default=default, annotation=_annotation(each, panel)
        )


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


def _annotation(field: Field[Any], panel: str | None) -> Any:
    """Return the type of an input on the command line, with its option."""
    settings = dict(field.metadata["option"])
    group = settings.pop("group", panel)
    if "kind" not in settings:
        kind, option = get_args(_SHARED[field.name])
        option = copy(option)  # others have the same option in another group, or in none
    else:
        kind, flag = settings.pop("kind"), settings.pop("flag", "")
        if kind_of_document := settings.pop("completes", ""):
            settings["autocompletion"] = names_of(kind_of_document)
        help = settings.pop("help", field.metadata["text"].replace("``", ""))
        if flag == "-":
            option = typer.Argument(help=help, **settings)
        else:
            flag = flag or f"--{field.name.replace('_', '-')}"
            option = typer.Option(flag, help=help, **settings)
    option.rich_help_panel = group
    return Annotated[kind, option]
