"""Objects of an exploration of pairs: seen objects, and stacks that a meta-catalog knows."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

from cbdsl.api.reading.clean import require_clean
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.document import NAME_PATTERN
from cbdsl.documents.meta_catalog import MetaCatalogDocument
from cbdsl.yaml_text.library import Library

if TYPE_CHECKING:
    from pathlib import Path

#: Mark before the name of a meta-catalog, in the place of a channel.
STACK = "@"


class ExploredThing(NamedTuple):
    """Object of an exploration of pairs.

    Attributes:
        channel: Channel of the object; of its upper part if it is a stack.
        base: Channel of the lower part of a stack; empty otherwise.
        meta_catalog: Meta-catalog with the pair that the stack is; empty otherwise.
    """

    channel: str
    base: str = ""
    meta_catalog: str = ""

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels of all its parts."""
        return (self.channel, self.base) if self.base else (self.channel,)


def read_things(things: Mapping[str, str], folder: Path | None = None) -> dict[str, ExploredThing]:
    """Return objects that have distinct channels and make pairs, by name.

    Args:
        things: Channels of the objects by name. A stack has the name of its pair, and ``@`` and the
            name or file of a meta-catalog with this pair instead of a channel.
        folder: Folder to search for documents by name; the working folder if ``None``.

    Raises:
        DiagnosticsError: A meta-catalog has errors.
        UsageError: A name is not allowed, a channel occurs twice, or there is one object.
    """
    known: dict[str, ExploredThing] = {}
    taken: set[str] = set()
    for name, text in things.items():
        if not text or not re.fullmatch(NAME_PATTERN, name):
            raise UsageError(f"thing '{name}': a name and its channel, such as ball and red")
        known[name] = _thing(name, text, folder)
        for channel in known[name].channels:
            if channel in taken:
                raise UsageError(f"thing '{name}': another thing has the channel '{channel}'")
            taken.add(channel)
    if len(known) < 2:
        raise UsageError("pairs are of two things at least")
    return known


def values_of(upper: ExploredThing, lower: ExploredThing, name: str) -> Iterator[tuple[str, str]]:
    """Yield the parameters of a program that brings one object to another, with their values.

    Args:
        upper: Object that is brought.
        lower: Object below it; a stack has two further values.
        name: Name of the lower object.
    """
    yield "feature", upper.channel
    yield "goal", lower.channel
    if lower.base:
        yield "base", lower.base
        yield "pair", name


def _thing(name: str, text: str, folder: Path | None) -> ExploredThing:
    if not text.startswith(STACK):
        return ExploredThing(text)
    library = Library(folder)
    file = library.locate(MetaCatalogDocument, text.removeprefix(STACK))
    require_clean(file, library)
    catalog = library.read(file, MetaCatalogDocument).document
    if name not in catalog.pairs:
        raise UsageError.unknown(f"pair of '{catalog.name}'", name, catalog.pairs)
    pair = catalog.pairs[name]
    if pair.with_reward is None:
        raise UsageError(f"thing '{name}': by '{catalog.name}', this pair never stayed")
    ends = catalog.things[pair.upper], catalog.things[pair.lower]
    return ExploredThing(ends[0].feature, ends[1].feature, catalog.name)
