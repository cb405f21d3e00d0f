"""The page: complete, self-contained, and the same for the same recording."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from dataclasses import replace
from html.parser import HTMLParser
from importlib.resources import files
from typing import Any

import pytest

from cbdsl.reporting.diagnoses import DIAGNOSES
from cbdsl.reporting.page import page
from cbdsl.reporting.recorded import Recorded

VENDOR = files("cbdsl.reporting") / "assets" / "vendor"


class Loads(HTMLParser):
    """Parser that collects all addresses that elements would load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self.policy = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.found += [str(given[key]) for key in ("src", "href", "data", "srcset") if key in given]
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given.get("content") or ""


def header_of(text: str) -> dict[str, Any]:
    """Return the header of a page's data."""
    (packed,) = re.findall(r'id="data">([^<]*)<', text)
    content = zlib.decompress(base64.b64decode(packed))
    header: dict[str, Any] = json.loads(content[4 : 4 + int.from_bytes(content[:4], "little")])
    return header


@pytest.fixture(scope="module")
def text(recorded: Recorded) -> str:
    return page(recorded)


def test_page_of_a_recording_loads_nothing(text: str) -> None:
    parser = Loads()
    parser.feed(text)
    assert parser.found == ["data:,"]
    assert parser.policy.startswith("default-src 'none';")
    assert not re.search(r"connect-src|https?:", parser.policy)


def test_same_recording_gives_the_same_page(recorded: Recorded, text: str) -> None:
    assert page(recorded) == text
    result = {**recorded.summary["result"], "wall_seconds": 99.0, "renderer": "another"}
    other = replace(recorded, summary={**recorded.summary, "result": result})
    assert page(other) == text


def test_page_without_an_installed_diagnosis_has_the_end_and_no_causes(
    recorded: Recorded, monkeypatch: pytest.MonkeyPatch
) -> None:
    failed = {**recorded.summary["result"], "succeeded": False}
    other = replace(recorded, summary={**recorded.summary, "result": failed})
    DIAGNOSES.refresh()
    monkeypatch.setattr(DIAGNOSES, "_offers", {})
    header = header_of(page(other))
    assert (header["failed"], header["causes"]) == (True, [])


def test_page_of_a_recording_is_below_5_mb(text: str) -> None:
    assert len(text.encode()) < 5e6


def test_title_cannot_be_markup(recorded: Recorded) -> None:
    result = {**recorded.summary["result"], "program": "</title><b>{{data}}"}
    text = page(replace(recorded, summary={**recorded.summary, "result": result}))
    assert "<title>&lt;/title&gt;&lt;b&gt;{{data}}, seed 0</title>" in text


def test_page_has_exactly_two_script_ends(text: str) -> None:
    assert len(re.findall(r"</script", text, re.IGNORECASE)) == 2


def test_libraries_are_those_that_their_page_lists(text: str) -> None:
    listed = dict(
        re.findall(
            r"^\| (\S+) \|.*\| (\w{64}) \|$", (VENDOR / "README.md").read_text("utf-8"), re.M
        )
    )
    kept = {each.name for each in VENDOR.iterdir() if ".min." in each.name}
    assert set(listed) == kept
    for name, digest in listed.items():
        assert hashlib.sha256((VENDOR / name).read_bytes()).hexdigest() == digest
    assert "three.js authors" in text and "Leon Sorokin" in text
