"""Digests of small runs of experiments: ``python reproduction/tests/small_runs.py`` records them.

Run it after a change that is meant to change results, such as of the control law.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from llvmlite.binding import get_host_cpu_name

from cbdsl_reproduction.experiment import RunSettings
from cbdsl_reproduction.registry import EXPERIMENTS
from cbdsl_reproduction.report import data

RECORDED = Path(__file__).with_name("digests.json")
#: Experiments whose small run takes more than 20 s, or needs an engine with physics.
LONG = {"engines", "fig-5.3-5.5", "fig-7.16-7.17", "table-7.1-7.2"}
#: Durations of episodes, which differ from run to run.
_WALL = re.compile(r" in \d+\.\d\d s| and \d+ s of wall time")


def processor() -> str:
    """Return the processor that machine code is made for; others round differently."""
    return str(get_host_cpu_name())


def recorded() -> tuple[str, dict[str, str]]:
    """Return the processor of the recorded digests, and the digests by experiment."""
    kept = json.loads(RECORDED.read_text("utf-8"))
    return kept["processor"], kept["digests"]


def digest(name: str, folder: Path) -> str:
    """Return the digest of the outcome of a small run: one trial, kinematic if possible.

    Args:
        name: Name of the experiment.
        folder: Empty folder for its episodes.
    """
    experiment = EXPERIMENTS[name]
    settings = RunSettings(
        quick=True,
        trials=1 if experiment.learns or experiment.keeps else None,
        cameras="ideal" if experiment.backend else None,
        folder=folder,
    )
    outcome = data(experiment, settings, experiment.load()(settings))
    text = json.dumps(outcome, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(_WALL.sub("", text).encode()).hexdigest()[:16]


def main(names: list[str]) -> None:
    """Record the digests of experiments, or of all short ones."""
    known = recorded()[1]
    for name in names or [each for each in EXPERIMENTS if each not in LONG]:
        with TemporaryDirectory() as folder:
            known[name] = digest(name, Path(folder))
        ordered = {each: known[each] for each in EXPERIMENTS if each in known}
        kept = {"processor": processor(), "digests": ordered}
        RECORDED.write_text(json.dumps(kept, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
