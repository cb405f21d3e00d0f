"""Readers of files from arbitrary sources: time in proportion to size, and bounds."""

from __future__ import annotations

import gc
import io
import shutil
import time
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.errors import DiagnosticsError, UsageError
from cbdsl.language.parser import parse
from cbdsl.reporting import recorded
from cbdsl.reporting.page import page
from cbdsl.reporting.recorded import read_recording
from cbdsl.robot.meshes import mesh_damage
from cbdsl.robot.meshes.triangles import MOST, read_triangles
from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.srdf import parse_srdf
from cbdsl.robot.urdf import UrdfError
from cbdsl.robot.urdf_reader import parse_urdf
from cbdsl.storage.atomic_file import write_text
from cbdsl.storage.journal import rows_of
from cbdsl.yaml_text.git_ignore import GitIgnore
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

FILE = Path("any")
JOINT = (
    '<joint name="j{0}" type="revolute"><parent link="l{1}"/><child link="l{0}"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)
ROBOT = (ROOT / "robots" / "panda.yaml").read_text("utf-8")
POLICY = (ROOT / "knowledge" / "policies" / "reachtouch.yaml").read_text("utf-8")
ERRORS = (DiagnosticsError, UsageError, UrdfError)

Read = Callable[[Path, int], object]


def urdf(count: int, parent: Callable[[int], int]) -> str:
    links = "".join(f'<link name="l{n}"/>' for n in range(count))
    joints = "".join(JOINT.format(n, parent(n)) for n in range(1, count))
    return f'<robot name="r">{links}{joints}</robot>'


def checked(folder: Path, name: str, text: str) -> object:
    (folder / name).write_text(text, encoding="utf-8")
    return check_document(folder / name, Session(Library(ROOT), {}))


def robot_of(folder: Path, model: str) -> object:
    (folder / "panda.urdf").write_text(model)
    return checked(folder, "panda.yaml", ROBOT)


def mesh(folder: Path, name: str, text: str | bytes) -> object:
    data = text.encode() if isinstance(text, str) else text
    (folder / name).write_bytes(data)
    return read_triangles(folder / name)


def damage(folder: Path, name: str, text: str | bytes) -> object:
    data = text.encode() if isinstance(text, str) else text
    (folder / name).write_bytes(data)
    mesh_damage._damage.cache_clear()
    return mesh_damage.mesh_damage(folder / name)


def stl(count: int) -> bytes:
    return bytes(80) + count.to_bytes(4, "little") + bytes(range(50)) * count


def xacro(folder: Path, body: str) -> object:
    from cbdsl_formats.expansion import expand_xacro

    file = folder / "any.xacro"
    file.write_text(f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{body}</robot>')
    return expand_xacro(file, "any", {}, PackageFolders({}, [], file)).text


def ignored(folder: Path, lines: str) -> object:
    (folder / ".gitignore").write_text(lines)
    rules = GitIgnore().with_folder(folder)
    return rules.ignores(folder / ("a" * 200), is_folder=False)


# A name, the count n, and the reader of n parts.
READERS: dict[str, tuple[int, Read]] = {
    "urdf chain": (450, lambda _, n: parse_urdf(urdf(n, lambda k: k - 1), FILE)),
    "urdf star": (3000, lambda _, n: parse_urdf(urdf(n, lambda k: 0), FILE)),
    "urdf elements": (40_000, lambda _, n: parse_urdf(f"<robot>{'<a/>' * n}</robot>", FILE)),
    "robot chain": (400, lambda folder, n: robot_of(folder, urdf(n, lambda k: k - 1))),
    "robot star": (3000, lambda folder, n: robot_of(folder, urdf(n, lambda k: 0))),
    "srdf": (
        8000,
        lambda _, n: parse_srdf(
            "<robot name='r'>" + "".join(f"<group name='g{k}'/>" for k in range(n)) + "</robot>",
            FILE,
        ),
    ),
    "xacro expressions": (500, lambda folder, n: xacro(folder, '<a b="${1 + 2}"/>' * n)),
    "xacro text": (8_000, lambda folder, n: xacro(folder, f'<a b="{"${1}" * n}"/>')),
    "obj": (30_000, lambda folder, n: mesh(folder, "a.obj", "v 0 0 0\n" * n + "f 1 2 3\n" * n)),
    "stl text": (60_000, lambda folder, n: mesh(folder, "a.stl", "solid\n" + "vertex 0 1 2\n" * n)),
    "stl bytes": (40_000, lambda folder, n: mesh(folder, "a.stl", stl(n))),
    "robot mesh obj": (
        40_000,
        lambda folder, n: damage(folder, "a.obj", "v 0 0 0\n" * n + "f 1 2 3\n" * n + "f 1\n"),
    ),
    "robot mesh obj digits": (
        200_000, lambda folder, n: damage(folder, "a.obj", f"v {'1' * n} {'1.' * n}\nf {'1' * n}x")
    ),
    "robot mesh obj corners": (40_000, lambda folder, n: damage(folder, "a.obj", "f" + " 1" * n)),
    "robot mesh stl text": (
        40_000,
        lambda folder, n: damage(folder, "a.stl", "solid\n" + "vertex 0 1 2\n" * n + " " * n),
    ),
    "robot mesh stl bytes": (40_000, lambda folder, n: damage(folder, "a.stl", stl(n))),
    "robot mesh collada": (
        60_000,
        lambda folder, n: damage(
            folder, "a.dae", f'<COLLADA><float_array count="{n}">{"0 " * n}</float_array></COLLADA>'
        ),
    ),
    "robot mesh collada elements": (
        60_000, lambda folder, n: damage(folder, "a.dae", f"<COLLADA>{'<p>0</p>' * n}</COLLADA>")
    ),
    "policy key": (450, lambda folder, n: checked(folder, "p.yaml", policy_key("*" * n))),
    "policy keys": (
        400, lambda folder, n: checked(folder, "p.yaml", policy_key(*map(str, range(n))))
    ),
    "long text": (4500, lambda folder, n: checked(folder, "p.yaml", POLICY + f"x: {'[' * n}")),
    "long line": (2200, lambda folder, n: checked(folder, "p.yaml", POLICY + "\n'x" + "- " * n)),
    "comments": (8000, lambda folder, n: checked(folder, "p.yaml", POLICY + "# word\n" * n)),
    "composition": (2000, lambda _, n: parse(" ◁ ".join(["reach"] * n))),
    "journal": (20_000, lambda _, n: rows_of(b'{"a": [1, 2]}\n' * n, FILE)),
    "ignored files": (400, lambda folder, n: ignored(folder, "a*b\n" * n)),
}  # fmt: skip


def policy_key(*keys: str) -> str:
    rows = "".join(f"  '{key}': reach\n" for key in keys)
    return POLICY.replace("policy:\n", f"policy:\n{rows}", 1)


def seconds(read: Read, folder: Path, count: int) -> float:
    """Return the processor time of a reading, the shortest of several."""
    times = []
    for _ in range(4):
        gc.collect()
        gc.disable()  # its searches come when other tests' objects say
        began = time.process_time()
        try:
            with suppress(*ERRORS):
                read(folder, count)
        finally:
            gc.enable()
        times.append(time.process_time() - began)
    return min(times)


def grows_linearly(read: Read, folder: Path, count: int) -> bool:
    """Return whether a reading of twice the size takes at most 2.5 times as long."""
    return seconds(read, folder, 2 * count) <= 2.5 * seconds(read, folder, count) + 0.002


@pytest.mark.parametrize("name", READERS)
def test_reader_of_twice_the_size_takes_little_more_than_twice_the_time(
    name: str, tmp_path: Path
) -> None:
    count, read = READERS[name]
    with suppress(*ERRORS):
        read(tmp_path, count)  # imports and caches
    # A reader of quadratic time fails every try; caches that others fill, only some.
    assert any(grows_linearly(read, tmp_path, count) for _ in range(5))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("deep chain", "a chain of more than 1000 joints"),
        ("many links", "a model has at most 10000"),
        ("large file", "larger than 4000000 bytes"),
        ("entities", "declares XML entities"),
    ],
)
def test_urdf_beyond_its_bounds_is_refused(name: str, words: str, tmp_path: Path) -> None:
    from cbdsl.robot.urdf_reader import read_urdf

    texts = {
        "deep chain": urdf(1500, lambda k: k - 1),
        "many links": urdf(10_500, lambda k: 0),
        "large file": " " * 4_000_001,
        "entities": "<!DOCTYPE r [<!ENTITY a 'x'>]><robot name='&a;'><link name='a'/></robot>",
    }
    (tmp_path / "any.urdf").write_text(texts[name])
    with pytest.raises(UrdfError, match=words):
        read_urdf(tmp_path / "any.urdf")


@pytest.mark.parametrize(
    "text", ["f 1 2 3\n" * (MOST + 1), "f " + "1 2 3 " * MOST, "v 0 0 0\n" * (3 * MOST + 3)]
)
def test_mesh_of_too_many_triangles_is_refused_while_it_is_read(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text(f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{text}")
    with pytest.raises(UsageError, match="more than 200000 triangles"):
        read_triangles(tmp_path / "a.obj")


def test_sparse_mesh_is_refused_before_it_is_read(tmp_path: Path) -> None:
    with (tmp_path / "a.stl").open("wb") as file:
        file.truncate(13 * 10**9)
    with pytest.raises(UsageError, match="larger than 20000000 bytes"):
        read_triangles(tmp_path / "a.stl")


def recording(folder: Path, parts: dict[str, tuple[bytes, int]]) -> Path:
    """Write a recording of arrays, each a header and a number of zeros behind it."""
    shutil.copy(
        ROOT / "tests" / "fuzz" / "recording" / "episode_25.json", folder / "episode_0.json"
    )
    with zipfile.ZipFile(folder / "episode_0.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        for name, (head, zeros) in parts.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as part:
                part.write(head)
                for _ in range(zeros // 10**7):
                    part.write(bytes(10**7))
    return folder / "episode_0.json"


def header(*shape: int) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        stream, {"descr": "|u1", "fortran_order": False, "shape": shape}
    )
    return stream.getvalue()


def test_recording_that_unpacks_to_much_is_refused_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorded, "_MOST_ARRAY_BYTES", 10**7)
    file = recording(tmp_path, {"time": (header(2 * 10**7), 2 * 10**7)})
    with pytest.raises(UsageError, match="more than 10000000 bytes"):
        read_recording(file)


def test_recording_with_many_unknown_names_reads_none_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[object] = []
    monkeypatch.setattr(recorded, "_require_array", lambda *part: read.append(part))
    file = recording(tmp_path, {f"unknown_{n}": (header(0), 0) for n in range(2000)})
    with pytest.raises(UsageError, match="lacks time"):
        read_recording(file)
    assert read == []


def test_recording_with_lone_surrogates_is_read_and_shown(tmp_path: Path) -> None:
    folder = ROOT / "tests" / "fuzz" / "recording"
    text = (folder / "episode_25.json").read_text("utf-8")
    for place in ('"ending": "', '"joints": [\n  "', '"name": "'):
        assert place in text, place
        (tmp_path / "a.json").write_text(text.replace(place, f"{place}\\ud800", 1), "utf-8")
        shutil.copy(folder / "episode_25.npz", tmp_path / "a.npz")
        write_text(page(read_recording(tmp_path / "a.json")), tmp_path / "a.html")


def test_recording_with_an_array_larger_than_its_part_is_refused(tmp_path: Path) -> None:
    file = recording(tmp_path, {"time": (header(10**14), 0)})
    with pytest.raises(UsageError, match="damaged, or cut short"):
        read_recording(file)
