"""Checks of meta-catalog documents: their things, and pairs of these."""

from __future__ import annotations

from cbdsl.checking.knowledge.catalog import check_affordance
from cbdsl.checking.lookup.document_search import find_document
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.diagnostics.outcome import Outcome, Unknown
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.documents.meta_catalog import KnownThing, MetaCatalogDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.channel_names import channel_names
from cbdsl.yaml_text.loaded import Loaded


def examine_meta_catalog(
    loaded: Loaded[MetaCatalogDocument], session: Session, diagnostics: Diagnostics
) -> None:
    """Check that a meta-catalog's things are known, and its pairs join two of them, each once."""
    if loaded.diagnostics:
        return  # a graph with missing parts cannot be checked
    document, source, library = loaded.document, loaded.source, session.library
    path = find_document(RobotDocument, document.robot, source.place("robot"), library, diagnostics)
    body = session.body(path, diagnostics)
    for index, name in enumerate(document.over):
        place = source.place("over", index)
        find_document(MetaCatalogDocument, name, place, library, diagnostics, own=document.name)
    for name, thing in document.things.items():
        _check_thing(loaded, name, thing, session, body, diagnostics)
    _check_ends(loaded, diagnostics)
    for name, pair in document.pairs.items():
        if pair.impedance is not None and pair.impedance.names and document.relations is None:
            place = source.place("pairs", name, "impedance", "names")
            diagnostics.add("CB682", place, name=next(iter(pair.impedance.names)))
        check_affordance(loaded, ("pairs", name), pair, session, body, diagnostics)


def _check_thing(
    loaded: Loaded[MetaCatalogDocument],
    name: str,
    thing: KnownThing,
    session: Session,
    body: Outcome[CheckedRobot],
    diagnostics: Diagnostics,
) -> None:
    """Check that the robot has a thing's channel, and that the thing's catalog has the same one."""
    source = loaded.source
    if not isinstance(body, Unknown):
        channels = body.document.vision.channels
        known = [*channel_names(channels), *channels.aliases]
        if thing.feature not in known:
            place = source.place("things", name, "feature")
            robot = body.document.name
            diagnostics.add("CB664", place, names=known, name=thing.feature, robot=robot)
            return
    _check_stack(loaded, name, thing, session, body, diagnostics)
    if thing.catalog is None:
        return
    place = source.place("things", name, "catalog")
    path = find_document(CatalogDocument, thing.catalog, place, session.library, diagnostics)
    read = session.read(path, CatalogDocument, diagnostics)
    if not isinstance(read, Unknown) and not _same(read.document.feature, thing.feature, body):
        details = {"found": read.document.feature, "wanted": thing.feature}
        diagnostics.add("CB665", place, name=thing.catalog, **details)


def _check_stack(
    loaded: Loaded[MetaCatalogDocument],
    name: str,
    thing: KnownThing,
    session: Session,
    body: Outcome[CheckedRobot],
    diagnostics: Diagnostics,
) -> None:
    """Check that a stack is a pair of its meta-catalog, with the channel of its upper part."""
    if thing.meta_catalog is None:
        return
    place = loaded.source.place("things", name, "meta_catalog")
    library, own = session.library, loaded.document.name
    path = find_document(
        MetaCatalogDocument, thing.meta_catalog, place, library, diagnostics, own=own
    )
    read = session.read(path, MetaCatalogDocument, diagnostics)
    if isinstance(read, Unknown):
        return
    pair = read.document.pairs.get(name)
    if pair is None:
        names = list(read.document.pairs)
        diagnostics.add("CB666", place, names=names, name=name, catalog=thing.meta_catalog)
        return
    upper = read.document.things.get(pair.upper)
    if upper is not None and not _same(upper.feature, thing.feature, body):
        details = {"found": upper.feature, "wanted": thing.feature}
        diagnostics.add("CB667", place, name=pair.upper, **details)


def _same(one: str, other: str, body: Outcome[CheckedRobot]) -> bool:
    """Return whether two names mean the same channel."""
    aliases = {} if isinstance(body, Unknown) else body.document.vision.channels.aliases
    return aliases.get(one, one) == aliases.get(other, other)


def _check_ends(loaded: Loaded[MetaCatalogDocument], diagnostics: Diagnostics) -> None:
    """Check that each pair joins two things of the document, and occurs once."""
    document, source = loaded.document, loaded.source
    known: dict[tuple[str, str, str], str] = {}
    for name, pair in document.pairs.items():
        ends = {"upper": pair.upper, "lower": pair.lower}
        lacking = {key: end for key, end in ends.items() if end not in document.things}
        for key, end in lacking.items():
            place = source.place("pairs", name, key)
            diagnostics.add("CB661", place, names=list(document.things), name=end)
        if lacking:
            continue
        if pair.upper == pair.lower:
            diagnostics.add("CB662", source.place("pairs", name, "lower"), name=pair.lower)
            continue
        # The same two objects may be joined by ``on`` and by ``in``, which are different edges.
        other = known.setdefault((pair.upper, pair.relation, pair.lower), name)
        if other != name:
            details = {"upper": pair.upper, "relation": pair.relation, "lower": pair.lower}
            diagnostics.add("CB663", source.key("pairs", name), other=other, **details)
