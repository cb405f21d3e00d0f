"""Mutated input: ``cb validate`` never fails, hangs or shows a traceback, in any format."""

from __future__ import annotations

import contextlib
import io
import json
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cbdsl.cli.validation import FORMATS, check_paths
from tests.cli.mutations import documents

TOLERANT = settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
#: Number of examples of the long run.
MANY = int(os.environ.get("FUZZ_EXAMPLES", "2000"))


def survives(folder: Path, content: bytes, form: str) -> None:
    # The shipped robots are found here, and no document beside the file.
    path = folder / "programs" / "any.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    with contextlib.redirect_stdout(io.StringIO()) as out:
        code = check_paths([str(path)], {}, form, strict=True)
    printed = out.getvalue()
    assert code == ("no findings" not in printed) if form == "text" else code in (0, 1)
    assert "\x1b" not in printed and "Traceback" not in printed
    if form in ("json", "sarif"):
        json.loads(printed)
    printed.encode("utf-8")


@TOLERANT
@given(content=documents(), form=st.sampled_from(list(FORMATS)))
def test_any_mutation_is_reported_in_any_format(tmp_path: Path, content: bytes, form: str) -> None:
    survives(tmp_path, content, form)


@TOLERANT
@given(content=st.binary(max_size=200) | st.text(max_size=200).map(lambda t: t.encode()))
def test_any_bytes_are_reported(tmp_path: Path, content: bytes) -> None:
    survives(tmp_path, content, "text")


@pytest.mark.slow
@settings(TOLERANT, max_examples=MANY)
@given(content=documents() | st.binary(), form=st.sampled_from(list(FORMATS)))
def test_great_many_mutations_are_reported(tmp_path: Path, content: bytes, form: str) -> None:
    survives(tmp_path, content, form)
