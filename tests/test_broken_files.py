"""Random broken files of the readers of ``cb validate``: findings, in bounded time and memory."""

from __future__ import annotations

import random
import resource
import time
from collections import Counter
from pathlib import Path

import pytest

from cbdsl.checking.document import check_document
from cbdsl.checking.session import Session
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

FOLDERS = ("programs", "knowledge", "robots")
DOCUMENTS = sorted(file for folder in FOLDERS for file in (ROOT / folder).rglob("*.yaml"))
ROBOTS = sorted(f for f in (ROOT / "robots").glob("*.urdf") if f.with_suffix(".yaml").exists())
STAGE = ROOT / "programs" / "stages" / "football.yaml"
MESH = next(f for f in STAGE.parent.rglob("*") if f.suffix in (".stl", ".obj"))
PIECES = (b"*", b"[", b"- ", b"{", b'"', b" ", b"<a>", b"0", b"#", b": ")
COUNTS = (1, 50, 5000, 60_000)
MOST_SECONDS, MOST_MEGABYTES = 2.0, 300


def broken(data: bytes, rng: random.Random) -> bytes:
    """Return a text with a few random faults."""
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


def write_case(folder: Path, number: int, rng: random.Random) -> Path:
    """Write a broken document, robot model or mesh; return the document to check."""
    if number % 4 == 0:
        model = rng.choice(ROBOTS)
        (folder / model.name).write_bytes(broken(model.read_bytes(), rng))
        document = model.with_suffix(".yaml")
    elif number % 4 == 1:
        mesh = folder / MESH.relative_to(STAGE.parent)
        mesh.parent.mkdir(exist_ok=True)
        mesh.write_bytes(broken(MESH.read_bytes(), rng))
        document = STAGE
    else:
        document = rng.choice(DOCUMENTS)
        (folder / document.name).write_bytes(broken(document.read_bytes(), rng))
        return folder / document.name
    (folder / document.name).write_bytes(document.read_bytes())
    return folder / document.name


@pytest.mark.slow
def test_validate_of_a_thousand_broken_files_is_bounded(tmp_path: Path) -> None:
    rng, faulty, times = random.Random(5), Counter[int](), []
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for number in range(1000):
        file = write_case(tmp_path, number, rng)
        began = time.process_time()
        faulty[number % 4] += bool(check_document(file, Session(Library(tmp_path), {})))
        times.append(time.process_time() - began)
    assert max(times) < MOST_SECONDS
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < MOST_MEGABYTES * 1024
    assert min(faulty.values()) > 100, "most of each kind have findings"
