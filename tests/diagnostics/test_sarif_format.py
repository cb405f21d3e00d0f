"""SARIF against its published schema."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import unquote_to_bytes

import jsonschema
import pytest

from cbdsl.cli.validation import check_paths
from cbdsl.yaml_text.library import shipped

SCHEMA = json.loads(
    (Path(__file__).parent / "schemas" / "sarif-2.1.0-rtm.5.json").read_text("utf-8")
)
BAD = Path(__file__).parents[1] / "checking" / "bad"


def faults(log: Any) -> list[str]:
    """Return places and messages of all violations of the schema in a log."""
    validator = jsonschema.Draft4Validator(SCHEMA, format_checker=jsonschema.FormatChecker())
    return [f"{list(error.absolute_path)}: {error.message}" for error in validator.iter_errors(log)]


def log_of(capsys: pytest.CaptureFixture[str], *paths: Path) -> Any:
    check_paths([str(path) for path in paths], {}, "sarif")
    return json.loads(capsys.readouterr().out)


def test_findings_in_all_bad_documents_are_valid(capsys: pytest.CaptureFixture[str]) -> None:
    log = log_of(capsys, BAD)
    assert len(log["runs"][0]["results"]) > 400
    assert faults(log) == []


def test_no_findings_are_valid(capsys: pytest.CaptureFixture[str]) -> None:
    log = log_of(capsys, shipped() / "programs")
    assert log["runs"][0]["results"] == []
    assert faults(log) == []


def result(log: Any) -> Any:
    return log["runs"][0]["results"][0]


SPOILED: dict[str, Callable[[Any], object]] = {
    "a driver without a name": lambda log: log["runs"][0]["tool"]["driver"].pop("name"),
    "a result without a message": lambda log: result(log).pop("message"),
    "a level that is none": lambda log: result(log).update(level="fatal"),
    "a key that is none": lambda log: result(log).update(code="CB101"),
    "a line before the first": lambda log: result(log)["locations"][0]["physicalLocation"][
        "region"
    ].update(startLine=0),
}


@pytest.mark.parametrize("spoil", SPOILED.values(), ids=SPOILED)
def test_sarif_schema_rejects_an_invalid_report(
    spoil: Callable[[Any], object], capsys: pytest.CaptureFixture[str]
) -> None:
    log = log_of(capsys, BAD / "programs" / "type_clash.yaml")
    spoiled = copy.deepcopy(log)
    spoil(spoiled)
    assert faults(log) == [] and faults(spoiled) != []


@pytest.mark.parametrize(
    "name", [b"a b", b"a%41", b"a#b", b"a?b", b"a\nb", b"[x]", b"bad\xff", b"-x"]
)
@pytest.mark.parametrize("is_absolute", [True, False])
def test_file_of_any_name_has_an_address_that_leads_back(
    name: bytes,
    is_absolute: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path(os.fsdecode(name) + ".yaml")
    file.write_text("cbdsl: 1\nkind: program\nname: x\nrobot: nope\ncontrollers: {}\nactions: []\n")
    log = log_of(capsys, file.absolute() if is_absolute else file)
    assert faults(log) == []
    address = result(log)["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    path = unquote_to_bytes(address.removeprefix("file://"))
    assert os.path.samefile(path, file)
