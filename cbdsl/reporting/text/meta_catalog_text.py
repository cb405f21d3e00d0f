"""Meta-catalogs and their plans as text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from cbdsl.reporting.text.catalog_text import aligned, count_cells, feature_lines

if TYPE_CHECKING:
    from cbdsl.documents.meta_catalog import KnownThing, MetaCatalogDocument, PairSection

_TITLES = ("pair", "stayed", "95 % interval", "value", "model")
# Programs by number of stacked objects, and their parameters for the channels, from below.
_PROGRAMS = {2: ("stand", ("goal", "feature")), 3: ("stack_three", ("goal", "middle", "feature"))}


def meta_catalog_text(catalog: MetaCatalogDocument) -> str:
    """Return a meta-catalog as text: its objects, its pairs and their constellations."""
    head = f"{catalog.name}: which things {catalog.robot} brings to which"
    if catalog.provenance is not None:
        origin = catalog.provenance
        head += f", after {origin.actions} actions on {origin.stage.name}"
    things = ", ".join(f"{name} ({_known_by(thing)})" for name, thing in catalog.things.items())
    rows = [
        (f"{pair.upper} {pair.relation} {pair.lower}", *count_cells(pair))
        for pair in catalog.pairs.values()
    ]
    lines = [head, f"things: {things}", "", *aligned([_TITLES, *rows])]
    for name, pair in catalog.pairs.items():
        lines += feature_lines(name, pair)
        lines += _impedance_lines(name, pair)
    return "\n".join(lines) + "\n"


def _known_by(thing: KnownThing) -> str:
    stack = f", stack of {thing.meta_catalog}" if thing.meta_catalog else ""
    return f"{thing.feature}{stack}"


def _impedance_lines(name: str, pair: PairSection) -> Iterator[str]:
    """Yield the impedance of a pair, with the name of its relation."""
    from cbdsl.diagnostics.counting import count
    from cbdsl.types.direction import unit_of

    measured = pair.impedance
    if measured is None:
        return
    named = f": {measured.relation}" if measured.relation else ""
    names = ", ".join(f"{each} {number}" for each, number in measured.names.items())
    yield f"\n{name}, impedance of {count(measured.profiles, 'profile')}{named}"
    if names:
        yield f"  named      {names}"
    for direction, mean in measured.mean.items():
        tracked = measured.tracked.get(direction, 0)
        yield f"  {direction}  {mean:9.4g} {unit_of(direction):7s}  tracked {tracked}"


def stack_command(channels: Sequence[str]) -> str | None:
    """Return the command that stacks the objects of these channels, from below.

    Returns:
        Command, or ``None`` if no shipped program stacks so many.
    """
    if len(channels) not in _PROGRAMS:
        return None
    program, parameters = _PROGRAMS[len(channels)]
    given = " ".join(f"--with {k}={c}" for k, c in zip(parameters, channels, strict=True))
    return f"cb run {program} {given}"
