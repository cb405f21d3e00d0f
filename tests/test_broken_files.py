"""Random broken files of all readers: diagnostics, in bounded time and memory."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tests.conftest import ROOT

_MEASURE = """
import json
from benchmarks.broken_files import measure, memory
rows = {name: row._asdict() for name, row in measure(1000, seed=5)}
print(json.dumps({"rows": rows, "memory": memory()}))
"""


@pytest.mark.slow
def test_validate_of_a_thousand_broken_files_is_bounded() -> None:
    from benchmarks.broken_files import MOST_MEGABYTES, MOST_SECONDS

    done = subprocess.run(  # in a process of its own, whose memory is that of the readers
        [sys.executable, "-c", _MEASURE], cwd=ROOT, capture_output=True, text=True, check=True
    )
    told = json.loads(done.stdout)
    assert sum(row["files"] for row in told["rows"].values()) >= 1000
    for name, row in told["rows"].items():
        assert row["slowest"] < MOST_SECONDS, name
        is_any_valid = name == "rules of git"
        assert is_any_valid or row["faulty"] > row["files"] // 4, f"faults of {name} are noticed"
    assert told["memory"] < MOST_MEGABYTES
