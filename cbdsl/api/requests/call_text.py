"""Calls in Python that repeat a request, for the provenance of documents."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cbdsl.api.requests.run_request import RunRequest


def chosen(request: Any, names: Iterable[str], always: Collection[str] = ()) -> dict[str, object]:
    """Return the fields of a request that differ from their defaults, or are always written.

    Args:
        request: Instance of a dataclass.
        names: Fields to look at, in their order in the call.
        always: Fields that are written with their defaults, too.
    """
    values = {name: getattr(request, name) for name in names}
    declared = type(request).__dataclass_fields__
    return {
        name: value
        for name, value in values.items()
        if name in always or value != declared[name].default
    }


def load_text(run: RunRequest, values: Mapping[str, str]) -> str:
    """Return the call that loads a program on its stage, with values of its parameters."""
    inputs = (run.program.name, run.stage.name, dict(values))
    return "cbdsl.load({!r}, stage={!r}, values={!r})".format(*inputs)


def call_text(verb: str, arguments: Iterable[str], options: Mapping[str, object]) -> str:
    """Return a call of a verb, from the text of its arguments and its options by name."""
    words = [*arguments, *(f"{name}={value!r}" for name, value in options.items())]
    return f"cbdsl.{verb}({', '.join(words)})"
