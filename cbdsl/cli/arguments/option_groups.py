"""Groups of options: one parameter of a command for several words of the command line."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, get_type_hints


# Typer derives options from the signature of a command. A parameter whose type is a dataclass is a
# group: its fields, annotated as options, take its place in the signature that Typer reads. The
# command receives the group.
def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with an option for each field of its groups of options."""
    signature = inspect.signature(command, eval_str=True)
    groups: dict[str, Any] = {
        name: parameter.annotation
        for name, parameter in signature.parameters.items()
        if is_dataclass(parameter.annotation)
    }

    def flat(**given: Any) -> None:
        filled = {
            name: group(**{field.name: given.pop(field.name) for field in fields(group)})
            for name, group in groups.items()
        }
        command(**given, **filled)

    parameters = [
        option
        for name, parameter in signature.parameters.items()
        for option in (_options(groups[name]) if name in groups else (parameter,))
    ]
    flat.__name__, flat.__doc__, flat.__module__ = (
        command.__name__,
        command.__doc__,
        command.__module__,
    )
    flat.__annotations__ = {each.name: each.annotation for each in parameters}
    flat.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return flat


def _options(group: Any) -> Iterator[inspect.Parameter]:
    """Yield the options of a group as keyword parameters."""
    annotations = get_type_hints(group, include_extras=True)
    for field in fields(group):
        default = inspect.Parameter.empty if field.default is MISSING else field.default
        if field.default_factory is not MISSING:
            default = field.default_factory()
        kind, annotation = inspect.Parameter.KEYWORD_ONLY, annotations[field.name]
        yield inspect.Parameter(field.name, kind, default=default, annotation=annotation)
