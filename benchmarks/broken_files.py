"""Processor time and memory of the readers on randomly broken files.

The readers are those of ``cb validate``: all kinds of documents, robot models, meshes in three
forms and rules of git. Those of ``cb new robot`` are semantic groups and xacro. Each file is a
sound one with a few random faults: parts cut out, repeated or exchanged, and up to 60,000 brackets,
stars or tags in one place.

    python benchmarks/broken_files.py --files 1000 --seed 5
"""

from __future__ import annotations

import argparse
import random
import struct
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.diagnostics.errors import UsageError
from cbdsl.documents.kinds import KINDS
from cbdsl.robot.package_folders import PackageFolders
from cbdsl.robot.srdf import parse_srdf
from cbdsl.robot.urdf import UrdfError
from cbdsl.yaml_text.document_folder import documents_below
from cbdsl.yaml_text.library import Library, shipped
from cbdsl_formats.expansion import expand_xacro

PIECES = (b"*", b"[", b"- ", b"{", b'"', b" ", b"<a>", b"0", b"#", b": ", b"${", b"f 1 2 3\n")
# Long repetitions reveal recursion without a bound and quadratic time, which short faults miss.
COUNTS = (1, 50, 5000, 60_000)
#: Bounds of one file: processor time, s, and memory of all together, MB.
MOST_SECONDS, MOST_MEGABYTES = 2.0, 300

SRDF = b"""<robot name="panda"><group name="arm"><chain base_link="panda_link0"
tip_link="panda_link8"/></group><group_state name="ready" group="arm"><joint name="panda_joint1"
value="0.5"/></group_state><disable_collisions link1="a" link2="b" reason="Never"/></robot>"""
XACRO = b"""<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="n"
value="${2 * pi}"/><xacro:macro name="part" params="name *block"><link name="${name}_${n}"/>
<xacro:insert_block name="block"/></xacro:macro><xacro:if value="${n > 1}"><xacro:part name="a">
<link name="b"/></xacro:part></xacro:if></robot>"""
RULES = b"*.tmp\n/build/\n!keep.yaml\n**/cache/*\n[a-c]?.yaml\n# comment\n"
TRIANGLE = struct.pack(
    "<12fH", *(0.0, 0.0, 1.0), *(0.0, 0.0, 0.0), *(1.0, 0.0, 0.0), *(0.0, 1.0, 0.0), 0
)

Read = Callable[[Path, bytes], bool]


class Reader(NamedTuple):
    """Reader of one kind of file.

    Attributes:
        sound: Files without faults.
        read: Function that reads a file's content in a folder, and returns whether it has
            diagnostics.
    """

    sound: tuple[bytes, ...]
    read: Read


class Measured(NamedTuple):
    """Files of one reader that were read.

    Attributes:
        files: Number of files.
        faulty: Number of files with diagnostics.
        slowest: Processor time of the slowest file, s.
        slowest_file: Number of that file.
    """

    files: int
    faulty: int
    slowest: float
    slowest_file: int


def broken(data: bytes, rng: random.Random) -> bytes:
    """Return a content with one to four random faults."""
    for _ in range(rng.randint(1, 4)):
        one, other = sorted(rng.randrange(len(data) + 1) for _ in range(2))
        data = rng.choice(
            (
                data[:one] + data[one + rng.randint(1, 200) :],
                data[:one] + rng.randbytes(rng.randint(1, 40)) + data[one:],
                data[:one] + rng.choice(PIECES) * rng.choice(COUNTS) + data[one:],
                data[:other] + data[one:other] * 2 + data[other:],
                data[:other],
            )
        )
    return data


def readers() -> dict[str, Reader]:
    """Return all readers by the name of their kind of file."""
    folders = [shipped() / name for name in ("robots", "programs", "knowledge")]
    contents: dict[str, list[bytes]] = {}
    for file in (file for folder in folders for file in documents_below(folder).documents):
        data = file.read_bytes()
        kind = next(line for line in data.splitlines() if line.startswith(b"kind: "))
        contents.setdefault(kind.partition(b" ")[2].decode(), []).append(data)
    found = {
        kind: Reader(tuple(contents[kind]), _document(f"{KINDS.get(kind).folder}/any.yaml"))
        for kind in sorted(contents)
    }
    robot = shipped() / "robots" / "panda"
    meshes = shipped() / "programs" / "stages" / "meshes"
    return found | {
        "urdf": Reader((robot.with_suffix(".urdf").read_bytes(),), _urdf),
        "obj": Reader((next(meshes.glob("*.obj")).read_bytes(),), _mesh("football.obj")),
        "stl bytes": Reader((bytes(80) + struct.pack("<I", 99) + 99 * TRIANGLE,), _mesh("a.stl")),
        "stl text": Reader(
            (b"solid a\n" + 99 * b"vertex 0 1 2\n" + b"endsolid\n",), _mesh("a.stl")
        ),
        "rules of git": Reader((RULES,), _rules),
        "srdf": Reader((SRDF,), _srdf),
        "xacro": Reader((XACRO,), _xacro),
    }


def _document(path: str) -> Read:
    def read(_: Path, data: bytes) -> bool:
        # It stands in for a file beside the shipped documents that it refers to.
        file = shipped() / path
        return bool(check_document(file, Session(Library(shipped(), {file: data}), {})))

    return read


def _urdf(folder: Path, data: bytes) -> bool:
    (folder / "panda.urdf").write_bytes(data)
    return _beside(folder / "panda.yaml", (shipped() / "robots" / "panda.yaml").read_bytes())


def _beside(file: Path, document: bytes) -> bool:
    """Check a document whose other file is beside it; it refers to shipped documents."""
    file.write_bytes(document)
    return bool(check_document(file, Session(Library(file.parent), {})))


def _mesh(name: str) -> Read:
    def read(folder: Path, data: bytes) -> bool:
        (folder / "meshes").mkdir(exist_ok=True)
        (folder / "meshes" / name).write_bytes(data)
        stage = (shipped() / "programs" / "stages" / "football.yaml").read_bytes()
        return _beside(folder / "football.yaml", stage.replace(b"football.obj", name.encode()))

    return read


def _rules(folder: Path, data: bytes) -> bool:
    (folder / ".gitignore").write_bytes(data)
    (folder / "deep" / "er").mkdir(parents=True, exist_ok=True)
    (folder / "deep" / "er" / "a.yaml").write_text("cbdsl: 1\nkind: program\n")
    return not documents_below(folder / "deep").documents


def _srdf(folder: Path, data: bytes) -> bool:
    with suppress(UrdfError):
        parse_srdf(data, folder / "any.srdf")
        return False
    return True


def _xacro(folder: Path, data: bytes) -> bool:
    file = folder / "any.xacro"
    file.write_bytes(data)
    with suppress(UsageError, UrdfError):
        expand_xacro(file, "any", {}, PackageFolders({}, [], file))
        return False
    return True


def measure(files: int, seed: int) -> Iterator[tuple[str, Measured]]:
    """Read broken files with each reader in turn, and yield its measurements.

    Args:
        files: Number of files of all readers together.
        seed: Seed of the faults.
    """
    rng, kinds = random.Random(seed), readers()
    # Rounded up, so that each reader gets at least one file.
    share = -(-files // len(kinds))
    with tempfile.TemporaryDirectory() as folder:
        for name, reader in kinds.items():
            times, faulty = [], 0
            for _ in range(share):
                data = broken(rng.choice(reader.sound), rng)
                began = time.process_time()
                faulty += reader.read(Path(folder), data)
                times.append(time.process_time() - began)
            slowest = max(times)
            yield name, Measured(share, faulty, slowest, times.index(slowest))


def memory() -> float:
    """Return the largest memory of this process so far, MB."""
    # `ru_maxrss` would include the peak of the parent process.
    status = Path("/proc/self/status").read_text("ascii")
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=1000, help="files of all readers together")
    parser.add_argument("--seed", type=int, default=5, help="seed of the faults")
    given = parser.parse_args()
    print("reader           files  faulty  slowest")
    for name, found in measure(given.files, given.seed):
        print(f"{name:16}{found.files:6}{found.faulty:8}{found.slowest:7.2f} s", flush=True)
    print(f"memory {memory():.0f} MB")


if __name__ == "__main__":
    main()
