"""Checks of meta-catalog documents: their things, and pairs of these."""

from __future__ import annotations

from cbdsl.checking.findings import Findings
from cbdsl.checking.knowledge.catalog import check_affordance
from cbdsl.checking.lookup.documents import find_document
from cbdsl.checking.robot.checked_robot import CheckedRobot
from cbdsl.checking.session import Session
from cbdsl.documents.catalog import CatalogDocument
from cbdsl.documents.meta_catalog import KnownThing, MetaCatalogDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.robot.channel_names import channel_names
from cbdsl.yaml_text.loaded import Loaded


def examine_meta_catalog(
    loaded: Loaded[MetaCatalogDocument], session: Session, findings: Findings
) -> None:
    """Check that a meta-catalog's things are known, and its pairs join two of them, each once."""
    if loaded.faults:
        return  # a graph with missing parts cannot be checked
    document, source, library = loaded.document, loaded.source, session.library
    path = find_document(RobotDocument, document.robot, source.place("robot"), library, findings)
    body = session.body(path, findings)
    for index, name in enumerate(document.over):
        place = source.place("over", index)
        find_document(MetaCatalogDocument, name, place, library, findings, own=document.name)
    for name, thing in document.things.items():
        _check_thing(loaded, name, thing, session, body, findings)
    _check_ends(loaded, findings)
    for name, pair in document.pairs.items():
        check_affordance(loaded, ("pairs", name), pair, session, body, findings)


def _check_thing(
    loaded: Loaded[MetaCatalogDocument],
    name: str,
    thing: KnownThing,
    session: Session,
    body: CheckedRobot | None,
    findings: Findings,
) -> None:
    """Check that the robot has a thing's channel, and that the thing's catalog has the same one."""
    source = loaded.source
    if body is not None:
        channels = body.document.vision.channels
        known = [*channel_names(channels), *channels.aliases]
        if thing.feature not in known:
            place = source.place("things", name, "feature")
            robot = body.document.name
            findings.add("CB664", place, names=known, name=thing.feature, robot=robot)
            return
    if thing.catalog is None:
        return
    place = source.place("things", name, "catalog")
    path = find_document(CatalogDocument, thing.catalog, place, session.library, findings)
    read = session.read(path, CatalogDocument, findings)
    if read is not None and not _same(read.document.feature, thing.feature, body):
        details = {"found": read.document.feature, "wanted": thing.feature}
        findings.add("CB665", place, name=thing.catalog, **details)


def _same(one: str, other: str, body: CheckedRobot | None) -> bool:
    """Return whether two names mean the same channel."""
    aliases = {} if body is None else body.document.vision.channels.aliases
    return aliases.get(one, one) == aliases.get(other, other)


def _check_ends(loaded: Loaded[MetaCatalogDocument], findings: Findings) -> None:
    """Check that each pair joins two things of the document, and occurs once."""
    document, source = loaded.document, loaded.source
    known: dict[tuple[str, str, str], str] = {}
    for name, pair in document.pairs.items():
        ends = {"upper": pair.upper, "lower": pair.lower}
        lacking = {key: end for key, end in ends.items() if end not in document.things}
        for key, end in lacking.items():
            place = source.place("pairs", name, key)
            findings.add("CB661", place, names=list(document.things), name=end)
        if lacking:
            continue
        if pair.upper == pair.lower:
            findings.add("CB662", source.place("pairs", name, "lower"), name=pair.lower)
            continue
        other = known.setdefault((pair.upper, pair.relation, pair.lower), name)
        if other != name:
            details = {"upper": pair.upper, "relation": pair.relation, "lower": pair.lower}
            findings.add("CB663", source.key("pairs", name), other=other, **details)
