"""What a robot's document says of the resources that it gives rise to."""

from __future__ import annotations

from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.findings import Findings
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library, shipped

ROBOTS = sorted((shipped() / "robots").glob("*.yaml"))


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_every_resource_is_declared_in_the_robots_document(path: Path) -> None:
    body = Session().body(path, Findings())
    lines = path.read_text("utf-8").split("\n")
    for name, resource in body.resources.items():
        place = body.declaration(resource)
        word = lines[place.line - 1][place.column - 1 : place.end_column - 1]
        assert Path(place.file) == path
        assert word in {*name.split("."), "cameras"}, name


def test_a_clash_of_types_tells_where_both_resources_come_from(tmp_path: Path) -> None:
    program = tmp_path / "programs" / "clash.yaml"
    program.parent.mkdir()
    program.write_text(
        "cbdsl: 1\nkind: program\nname: clash\nrobot: dexter\ncontrollers:\n  press:\n"
        "    potential: spring\n    reference: left_hand.finger_1.force\n"
        "    feedback: right_arm.position\n    effector: right_arm\nactions: [press]\n",
        encoding="utf-8",
    )
    (clash,) = check_document(program, session=Session(Library(tmp_path)))
    lines = (shipped() / "robots" / "dexter.yaml").read_text("utf-8").split("\n")
    elsewhere = [r.place for r in clash.related if Path(r.place.file).name == "dexter.yaml"]
    assert clash.code == "CB504"
    assert [lines[p.line - 1].split(":")[0].strip() for p in elsewhere] == ["finger_1", "right_arm"]
