"""Records of sources: one for each type, whose names are attributes of the type."""

from __future__ import annotations

import re
from typing import get_args

import pytest

from cbdsl.types.resource import Heading, MarkHeading, SolidSignal, Source, Tip
from cbdsl.types.source_record import RECORDS, channels_of, declaration_of, owner_of

TYPES = get_args(Source)


def test_records_exist_for_all_sources() -> None:
    assert set(RECORDS) == set(TYPES)


@pytest.mark.parametrize("source", TYPES)
def test_record_names_attributes_of_its_source(source: type) -> None:
    record, fields = RECORDS[source], set(source._fields)  # type: ignore[attr-defined]
    named = {item[1:-1] for item in record.place if re.fullmatch(r"\{\w+\}", item)}
    assert named | set(record.channels) | ({record.owner} - {""}) <= fields


def test_facts_of_sources_follow_from_their_records() -> None:
    assert list(channels_of(SolidSignal("red", "green", "width"))) == ["red", "green"]
    assert list(channels_of(MarkHeading("red", ("blue", "green")))) == ["red", "blue", "green"]
    assert owner_of(Tip("arm", "position")) == "arm" and owner_of(Heading("left", "red")) == ""
    assert declaration_of(Heading("left", "red")) == ("cameras", "left")
