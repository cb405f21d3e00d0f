"""Proposed robots: values of arms for programs over roles."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cbdsl.robot.urdf_reader import read_urdf
from cbdsl.scaffold.proposal import propose

LIMIT = '<limit lower="-2" upper="2" effort="50" velocity="1"/>'


def _gap(folder: Path, hand: str) -> float:
    """Return the gap, cm, of an arm of 1 m with a jaw beyond its last link."""
    names = ("base", "upper", "lower", "wrist", "hand", "jaw")
    text = "".join(
        f'<joint name="{child}_joint" type="revolute"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="0 0 {length}"/><axis xyz="{axis}"/>{LIMIT}</joint>'
        for parent, child, length, axis in (
            ("base", "upper", 0.1, "0 0 1"),
            ("upper", "lower", 0.5, "0 1 0"),
            ("lower", "wrist", 0.5, "0 1 0"),
            ("hand", "jaw", 0, "0 1 0"),
        )
    )
    text += '<joint name="mount" type="fixed"><parent link="wrist"/><child link="hand"/></joint>'
    links = "".join(f'<link name="{n}">{hand if n == "hand" else ""}</link>' for n in names)
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm">{links}{text}</robot>')
    values = propose(read_urdf(path), folder).values["effectors"]
    match = re.search(r"gap: (\S+) cm", values)
    assert match is not None
    return float(match[1])


@pytest.mark.parametrize(
    ("place", "size", "beyond"),
    [
        ("0 0 0.1", "0.06 0.06 0.2", 20.0),  # beyond the flange, along z
        ("0.1 0 0", "0.2 0.06 0.08", 4.0),  # along x: half of its width
        ("0 0 -0.1", "0.06 0.06 0.2", 0.0),  # behind the flange
    ],
)
def test_gap_of_an_arm_reaches_beyond_the_hand(
    tmp_path: Path, place: str, size: str, beyond: float
) -> None:
    shape = f'<origin xyz="{place}"/><geometry><box size="{size}"/></geometry>'
    alone = _gap(tmp_path, "")
    assert _gap(tmp_path, f"<collision>{shape}</collision>") == pytest.approx(
        alone + beyond, abs=0.51
    )
