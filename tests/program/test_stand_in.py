"""Programs stand in for programs with the same reward, under any name."""

from __future__ import annotations

from pathlib import Path

from cbdsl.checking.session import Session
from cbdsl.cli.show.substitutes import stand_ins_of
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.stand_in import stand_ins
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT, Checked


def found(program: CheckedProgram, *others: CheckedProgram) -> list[tuple[str, str]]:
    return [(each.member, each.program) for other in others for each in stand_ins(program, other)]


def test_a_probe_stands_in_for_a_touch_and_two_hands_for_one(checked: Checked) -> None:
    probe, both = checked("tactileprobe"), checked("bimanualtouch")
    assert found(checked("reachtouch"), probe) == [("touch", "tactileprobe")]
    assert found(checked("visualinspect"), both) == [("reachtouch", "bimanualtouch")]
    # The programs that use it can be no part of it.
    assert not found(checked("reachtouch"), both)
    assert not found(checked("reachtouch"), checked("reachtouch"))


def test_substitutes_are_compared_without_names(checked: Checked) -> None:
    reach, probe, look = checked("reachtouch"), checked("tactileprobe"), checked("searchtrack")
    primitives = {"b": probe.primitives["touch"]._replace(name="b")}
    palpate = probe._replace(name="palpate", members=("a", "b"), primitives=primitives)
    assert found(reach, palpate) == [("touch", "palpate")]
    # Called a touch, it is still rewarded for its visual feature.
    track = look.primitives["track"]._replace(name="touch")
    decoy = look._replace(name="tactileprobe", primitives={"touch": track})
    assert "touch" not in dict(found(reach, decoy))


def test_unrewarded_program_is_no_substitute(checked: Checked) -> None:
    reach, probe = checked("reachtouch"), checked("tactileprobe")
    unpaid = probe._replace(primitives={"search": probe.primitives["search"]})
    assert not found(reach, unpaid)


def test_a_renamed_file_is_found(tmp_path: Path) -> None:
    text = (ROOT / "programs" / "tactileprobe.yaml").read_text(encoding="utf-8")
    other = text.replace("tactileprobe", "palpate").replace(" touch", " press")
    (tmp_path / "palpate.yaml").write_text(other, encoding="utf-8")
    source = (ROOT / "programs" / "reachtouch.yaml").read_text(encoding="utf-8")
    path = tmp_path / "reachtouch.yaml"
    path.write_text(source, encoding="utf-8")
    library = Library(ROOT)
    rows = stand_ins_of(path, Session(library), {})
    assert ("touch", "palpate") in [(each.member, each.program) for each in rows]
    assert library.find(ProgramDocument, "palpate", path) is not None
