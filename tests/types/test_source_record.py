"""Records of sources: one for each type, whose names are attributes of the type."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest

from cbdsl.types import source_record
from cbdsl.types.resource import Heading, MarkHeading, SolidSignal, Source, Tip
from cbdsl.types.source_record import RECORDS, channels_of, declaration_of, owner_of

TYPES = get_args(Source)


#: Only this module tests the type of a source; all others ask for the facts of its record.
HOME = Path(source_record.__file__)
PACKAGES = (HOME.parents[1], HOME.parents[2] / "reproduction" / "cbdsl_reproduction")


def type_tests(text: str) -> Iterator[int]:
    """Yield the lines of a module that test whether an object is of a type of source."""
    names = {kind.__name__ for kind in TYPES}
    for node in ast.walk(ast.parse(text)):
        tested: list[ast.expr] = []
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "issubclass"):
            tested = node.args[1:]
        elif isinstance(node, ast.MatchClass):
            tested = [node.cls]
        elif isinstance(node, ast.Compare) and "type(" in ast.unparse(node):
            tested = node.comparators
        named = {ast.unparse(part).rpartition(".")[2] for each in tested for part in ast.walk(each)}
        if not names.isdisjoint(named):
            yield tested[0].lineno


@pytest.mark.parametrize(
    "text",
    [
        "isinstance(resource.source, Tip)",
        "isinstance(source, (Heading, resource.Headings))",
        "isinstance(source, Tip | Centroid)",
        "type(source) is Tip",
        "{type(one), type(other)} == {Centroid, Separation}",
        "match source:\n    case NetLoad(hand=name):\n        pass",
    ],
)
def test_type_tests_finds_every_form(text: str) -> None:
    assert list(type_tests(text))


def test_type_tests_passes_facts_and_tables() -> None:
    text = (
        "isinstance(reference, Resource) and is_tip(source)\nTABLE = {Tip: 1}\nTip('arm', 'pose')"
    )
    assert not list(type_tests(text))


def test_no_module_but_the_home_tests_the_type_of_a_source() -> None:
    found = [
        f"{path}:{line}"
        for package in PACKAGES
        for path in sorted(package.rglob("*.py"))
        if path != HOME
        for line in type_tests(path.read_text())
    ]
    assert found == []


def test_records_exist_for_all_sources() -> None:
    assert set(RECORDS) == set(TYPES)


@pytest.mark.parametrize("source", TYPES)
def test_record_names_attributes_of_its_source(source: type) -> None:
    record, fields = RECORDS[source], set(source._fields)  # type: ignore[attr-defined]
    named = {item[1:-1] for item in record.place if re.fullmatch(r"\{\w+\}", item)}
    single = {record.owner, record.hues, record.links, record.features} - {""}
    assert named | set(record.channels) | single <= fields


def test_facts_of_sources_follow_from_their_records() -> None:
    assert list(channels_of(SolidSignal("red", "green", "width"))) == ["red", "green"]
    assert list(channels_of(MarkHeading("red", ("blue", "green")))) == ["red", "blue", "green"]
    assert owner_of(Tip("arm", "position")) == "arm" and owner_of(Heading("left", "red")) == ""
    assert declaration_of(Heading("left", "red")) == ("cameras", "left")
