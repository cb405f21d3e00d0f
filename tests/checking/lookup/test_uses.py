"""Programs that use programs: checking terminates, and its order changes no diagnostic."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library

CONTROLLER = "{potential: spring, reference: 0, feedback: cyclopean.motion, effector: head}"


def write(folder: Path, file: str, uses: dict[str, str], name: str = "") -> Path:
    """Write a program that uses others; each key has the text after ``program:``."""
    lines = [f"  {key}: {{program: {used}}}" for key, used in uses.items()]
    text = (
        f"cbdsl: 1\nkind: program\nname: {name or file}\nrobot: dexter\nparameters: {{v: motion}}\n"
        + (f"use:\n{chr(10).join(lines)}\n" if lines else "")
        + f"controllers:\n  track: {CONTROLLER.replace('motion', '$v')}\n"
        + f"actions: [{', '.join(['track', *uses])}]\n"
        + f'policy: {{"{"*" * (1 + len(uses))}": track}}\n'
    )
    path = folder / "programs" / f"{file}.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def codes(path: Path, folder: Path) -> list[str]:
    found = check_document(path, session=Session(Library(folder)))
    # No policy of these programs chooses the programs that they use, which is noted.
    return [f"{Path(d.place.file).stem}:{d.code}" for d in found if d.code != "CB732"]


def chain(folder: Path, length: int, with_: tuple[str, str] = ("$v", "$v")) -> Path:
    """Write programs that each use the next one twice, with these values."""
    for n in range(length):
        uses = {
            key: f"p{n + 1}, with: {{v: {value}}}"
            for key, value in zip(("a", "b"), with_, strict=True)
        }
        write(folder, f"p{n}", uses)
    write(folder, f"p{length}", {})
    return folder / "programs" / "p0.yaml"


def test_program_used_twice_is_checked_once(tmp_path: Path) -> None:
    assert codes(chain(tmp_path, 50), tmp_path) == []  # without reuse 2**50 programs


def test_programs_with_values_of_their_own_are_counted(tmp_path: Path) -> None:
    found = codes(chain(tmp_path, 12, ("$v-1", "$v-2")), tmp_path)  # 2**12 programs
    assert "CB610" in {code.split(":")[1] for code in found}


def test_value_does_not_grow_for_ever(tmp_path: Path) -> None:
    found = codes(chain(tmp_path, 60, ("$v$v", "$v$v")), tmp_path)  # 6 * 2**60 characters
    assert "CB409" in {code.split(":")[1] for code in found}


@pytest.mark.parametrize("name", ["self", "other"])
def test_program_is_known_by_its_file_not_by_its_name(name: str, tmp_path: Path) -> None:
    path = write(tmp_path, "self", {"again": "self"}, name=name)
    assert "self:CB605" in codes(path, tmp_path)


GRAPHS = st.lists(st.sets(st.integers(0, 5), max_size=3), min_size=6, max_size=6)


@settings(
    max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(graph=GRAPHS, order=st.permutations(range(6)))
def test_order_of_checking_changes_nothing(
    graph: list[set[int]], order: list[int], tmp_path: Path
) -> None:
    paths = [
        write(tmp_path, f"p{n}", {f"u{used}": f"p{used}" for used in sorted(uses)})
        for n, uses in enumerate(graph)
    ]
    session = Session(Library(tmp_path))
    together = {d for n in order for d in check_document(paths[n], session=session)}
    alone = {d for path in paths for d in check_document(path, session=Session(Library(tmp_path)))}
    assert together == alone
    circles = {d for d in together if d.code == "CB605"}
    assert bool(circles) == _has_a_circle(graph)


def _has_a_circle(graph: list[set[int]]) -> bool:
    """Return whether nodes remain after repeated removal of nodes without successors."""
    left = set(range(len(graph)))
    while leaves := {n for n in left if not graph[n] & left}:
        left -= leaves
    return bool(left)
