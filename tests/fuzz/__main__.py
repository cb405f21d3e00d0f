"""Fuzzing, guided by coverage, of everything that reads text: ``make fuzz SECONDS=60``.

Each entry point runs for that time from its seeds and from the kept corpus. Inputs that reach new
branches go to ``build/fuzz/NAME``; a shorter input replaces a longer one of the same reach. With
``--keep``, inputs of all lengths are kept in ``tests/fuzz/corpus``. An input that raises an error
is written to ``build/fuzz/NAME-crash-...`` (or ``-timeout-``, ``-oom-``) and ends the run.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from tests.cli.mutations import SPIKES
from tests.conftest import ROOT
from tests.fuzz.corpus import keep, kept
from tests.fuzz.entry_point import MODULES, entry_point

WORK = ROOT / "build" / "fuzz"
#: Seconds and megabytes for one input, and its bytes: an input that takes more is a fault.
LIMITS = ("-timeout=20", "-rss_limit_mb=2500", "-max_len=16384")
#: Inputs of an entry point that are kept, and bytes of each.
MOST, LARGEST = 60, 800
#: Words of the seeds that are recombined: keys, tags, attributes, names.
_WORD, _WORDS = re.compile(rb"[A-Za-z_][\w.]{2,30}"), 300


class Run(NamedTuple):
    """A run of an entry point: inputs that were read, branches that they reach, and faults."""

    executions: int
    branches: int
    seconds: int
    faults: tuple[Path, ...]


def fuzz(name: str, seconds: int, seed: int) -> Run:
    """Fuzz an entry point for so long."""
    work = WORK / name
    work.mkdir(parents=True, exist_ok=True)
    before = set(WORK.glob(f"{name}-*-*"))
    _write(work, [*entry_point(name).seeds(), *kept(name)])
    options = [
        *(f"-max_total_time={seconds}", f"-seed={seed}", f"-dict={_dictionary(name)}"),
        *(f"-artifact_prefix={WORK}/{name}-", "-print_final_stats=1", *LIMITS),
    ]
    told = _libfuzzer(name, [work], options)
    (WORK / f"{name}.log").write_text(told, encoding="utf-8")
    found = sorted(set(WORK.glob(f"{name}-*-*")) - before)
    counts = [_last(rf"{key}:\s+(\d+)", told) for key in ("number_of_executed_units", "cov")]
    return Run(*counts, seconds, tuple(found))


def keep_new(name: str) -> int:
    """Keep inputs of all lengths that reached something beyond the seeds; returns how many."""
    seeds = set(entry_point(name).seeds())
    reached = {file.read_bytes() for file in (WORK / name).iterdir()} - seeds
    short = sorted((each for each in reached if len(each) <= LARGEST), key=len)
    return keep(name, [*kept(name), *short[:: len(short) // MOST + 1]])


def _libfuzzer(name: str, folders: Sequence[Path], options: Sequence[str]) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "tests.fuzz.libfuzzer", name, *map(str, folders), *options],
        cwd=ROOT,
        capture_output=True,
    )
    return (done.stdout + done.stderr).decode("utf-8", "replace")


def _write(folder: Path, inputs: Iterable[bytes]) -> None:
    for each in inputs:
        (folder / hashlib.sha1(each).hexdigest()).write_bytes(each)


def _dictionary(name: str) -> Path:
    """Write words that readers may fail on and the commonest words of the seeds, for libFuzzer."""
    common = Counter(
        word for seed in entry_point(name).seeds() for word in set(_WORD.findall(seed))
    )
    words = [*SPIKES, *(word for word, _ in common.most_common(_WORDS))]
    file = WORK / f"{name}.dictionary"
    lines = ["".join(f"\\x{byte:02x}" for byte in word) for word in words]
    file.write_text("".join(f'"{line}"\n' for line in lines), encoding="ascii")
    return file


def _last(pattern: str, text: str) -> int:
    found = re.findall(pattern, text)
    return int(found[-1]) if found else 0


def main() -> int:
    """Fuzz entry points in turn; return 1 if something was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(MODULES)}")
    parser.add_argument("--seconds", type=int, default=60, help="for each entry point")
    parser.add_argument("--seed", type=int, default=1, help="of all chance")
    parser.add_argument("--keep", action="store_true", help="keep what reached something new")
    given = parser.parse_args()
    unknown = [name for name in given.names if name not in MODULES]
    if unknown:
        parser.error(f"no entry point {unknown[0]}; there are {', '.join(MODULES)}")
    total, faults = 0, 0
    for name in given.names or MODULES:
        run = fuzz(name, given.seconds, given.seed)
        total, faults = total + run.executions, faults + len(run.faults)
        kept_now = f", {keep_new(name)} kept" if given.keep else ""
        rate = run.executions / run.seconds
        sys.stdout.write(
            f"{name:20}{run.executions:10} executions, {rate:8.0f} a second, "
            f"{run.branches:6} branches, {len(run.faults)} faults{kept_now}\n"
        )
        for file in run.faults:
            sys.stdout.write(f"  {file}\n")
        sys.stdout.flush()
    sys.stdout.write(f"{total} executions, {faults} faults\n")
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
