"""Commands that repeat a call of ``cb``, in one spelling, for the provenance of documents."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import fields

import typer


def command_text(
    context: typer.Context,
    words: Sequence[str],
    request: type,
    out: str,
    *,
    also: Collection[str] = (),
    instead: Mapping[str, Sequence[str]] | None = None,
) -> str:
    """Return the command, with the options that differ from their defaults in declared order.

    Args:
        context: Parameters of the command.
        words: First words, up to its arguments.
        request: Class of the request, whose fields say if they are recorded.
        out: Name of the written file. Folders differ between computers, so that they are left out.
        also: Further recorded parameters.
        instead: Words of parameters with another spelling, by name.
    """
    options = _options(context, request, also, instead or {})
    return shlex.join([*words, "--out", out, *options])


def _options(
    context: typer.Context,
    request: type,
    also: Collection[str],
    instead: Mapping[str, Sequence[str]],
) -> Iterator[str]:
    inputs = {each.name: each for each in fields(request)}
    for parameter in context.command.params:
        name = str(parameter.name)
        value, declared = context.params[name], inputs.get(name)
        recorded = name in also if declared is None else declared.metadata["recorded"]
        always = declared is not None and declared.metadata["always"]
        is_argument = parameter.param_type_name == "argument"
        if name in instead:
            yield from instead[name]
        elif (
            is_argument
            or name == "out"
            or not recorded
            or (value == parameter.default and not always)
        ):
            continue
        elif value is True:
            yield parameter.opts[0]
        else:
            for each in value if isinstance(value, (list, tuple)) else [value]:
                yield from (parameter.opts[0], str(each))
