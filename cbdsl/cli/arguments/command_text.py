"""Commands that repeat a call of ``cb``, in one spelling, for the provenance of documents."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

import typer


def option_words(
    context: typer.Context,
    never: Collection[str],
    always: Collection[str],
    instead: Mapping[str, Sequence[str]] | None = None,
) -> Iterator[str]:
    """Yield the words of the options that differ from their defaults, in their declared order.

    Args:
        context: Parameters of the command.
        never: Parameters that do not affect the result, or are written otherwise.
        always: Parameters that are written with their defaults, too.
        instead: Words of parameters with another spelling, by name.
    """
    replaced = instead or {}
    for parameter in context.command.params:
        name = str(parameter.name)
        value = context.params[name]
        if name in replaced:
            yield from replaced[name]
        elif name in never or (value == parameter.default and name not in always):
            continue
        elif value is True:
            yield parameter.opts[0]
        else:
            for each in value if isinstance(value, (list, tuple)) else [value]:
                yield from (parameter.opts[0], str(each))
