"""Duration and quality of learning all five skills of Chapter 4 from scratch, for one seed.

The run works in a folder that initially has the shipped programs and robots and no knowledge. A
skill thus uses only skills learned in that folder. Each learned policy then runs held-out
episodes. Prints one line of JSON per skill and one for all of them: wall-clock, processor and
simulated seconds of learning, transitions, and rewarded episodes by context. Skills that are in the
folder are not learned again, so that an interrupted run can continue.

    python benchmarks/five_skills.py FOLDER --seed 2 [--backend kinematic] [--cameras ideal]
        [--held-out 50] [--try-on bullet] [--try-with rendered]

``--try-on`` and ``--try-with`` select the engine and the cameras of the held-out episodes.
"""

from __future__ import annotations

import argparse
import json
import resource
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cbdsl.yaml_text.library import shipped

CB = [sys.executable, "-c", "from cbdsl.cli.main import main; main()"]


@dataclass(frozen=True)
class Skill:
    """Policy to learn.

    Attributes:
        name: Name of the policy.
        program: Program of the policy.
        stage: Stage of the learning.
        options: Further words for ``cb learn``.
        held_out: Stage of the trial, unless it is the stage of the learning.
    """

    name: str
    program: str
    stage: str
    options: Sequence[str]
    held_out: str = ""


# Bottom up. Actions may take as long as in the source, or less where waiting teaches nothing, least
# while nothing moves.
SKILLS = (
    Skill("searchtrack", "searchtrack", "searchtrack_training", ("--episodes", "50")),
    Skill("searchtrack_table", "searchtrack", "table_training", ("--episodes", "50")),
    Skill(
        *("tactileprobe", "tactileprobe", "held_right"),
        ("--episodes", "25", "--density", "gaussian", "--prior", "25"),
    ),
    Skill(
        *("reachtouch", "reachtouch", "reachtouch_training"),
        (
            *("--episodes", "25", "--exploring-episodes", "15"),
            *("--transition-time", "8", "--idle-time", "1"),
        ),
    ),
    Skill(
        *("visualinspect", "visualinspect", "visualinspect_training"),
        ("--episodes", "50", "--transition-time", "5"),
        held_out="spotted_right",
    ),
    Skill(
        *("bimanualtouch", "bimanualtouch", "bimanualtouch_training"),
        # Without it, a search for objects out of reach takes hours of simulated time.
        ("--episodes", "25", "--episode-time", "300"),
        held_out="table_right",
    ),
)


def run(folder: Path, words: Sequence[str]) -> str:
    """Return the output of a ``cb`` command; an error ends the benchmark."""
    done = subprocess.run([*CB, *words], cwd=folder, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, 1):
        sys.exit(f"cb {' '.join(words)}: exit {done.returncode}")
    return done.stdout


def _body(backend: str, cameras: str | None) -> list[str]:
    """Return the words for ``cb`` that choose backend and cameras."""
    return ["--backend", backend, *(["--cameras", cameras] if cameras else [])]


def _tried(options: argparse.Namespace) -> tuple[str, str | None]:
    """Return backend and cameras of held-out episodes, by default those of learning."""
    backend = options.try_on or options.backend
    cameras = options.cameras if backend == options.backend else None
    return backend, options.try_with or cameras


def processor_time() -> float:
    """Return the processor time of all commands so far, s."""
    return sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])


def learned(folder: Path, skill: Skill, options: argparse.Namespace) -> dict[str, Any]:
    """Learn a policy, unless it is there already, and return the times that it took."""
    policy = folder / "knowledge" / "policies" / f"{skill.name}.yaml"
    clock = policy.with_suffix(".seconds")
    if not policy.exists():
        began = [time.perf_counter(), processor_time()]
        where = (
            "--stage",
            skill.stage,
            *_body(options.backend, options.cameras),
            "--seed",
            str(options.seed),
        )
        out = ("--out", str(policy), "--resume")
        run(folder, ("learn", skill.program, *where, *skill.options, *out))
        ended = [time.perf_counter(), processor_time()]
        clock.write_text(json.dumps([round(b - a, 1) for a, b in zip(began, ended, strict=True)]))
    journal = policy.with_suffix(".episodes.jsonl").read_text().splitlines()
    episodes = [json.loads(line) for line in journal[1:]]
    wall, processor = json.loads(clock.read_text())
    return {
        "wall_seconds": wall,
        "processor_seconds": processor,
        "sim_seconds": round(sum(each["sim_seconds"] for each in episodes), 1),
        "transitions": sum(len(each["transitions"]) for each in episodes),
    }


def held_out(folder: Path, skill: Skill, options: argparse.Namespace) -> dict[str, list[int]]:
    """Run a learned policy where it did not learn: rewarded episodes and all, by context."""
    backend, cameras = _tried(options)
    kept = folder / f"held_out_{skill.name}_{backend}_{cameras or 'own'}.jsonl"
    if not kept.exists():
        stage = skill.held_out or skill.stage
        policy = ("--policy", f"knowledge/policies/{skill.name}.yaml", "--stage", stage)
        how = (*_body(backend, cameras), "--episodes", str(options.held_out))
        kept.write_text(
            run(
                folder,
                (
                    "run",
                    skill.program,
                    *policy,
                    *how,
                    "--seed",
                    str(options.held_out_seed),
                    "--json",
                ),
            )
        )
    episodes = [json.loads(line) for line in kept.read_text().splitlines()]
    rewarded = Counter(each["context"] for each in episodes if each["rewarded"])
    shown = Counter(each["context"] for each in episodes)
    return {context: [rewarded[context], shown[context]] for context in sorted(shown)}


def main() -> None:
    """Learn, try, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--held-out-seed",
        type=int,
        default=900_000,
        help="of the first held-out episode [%(default)s]",
    )
    parser.add_argument("--backend", default="bullet")
    parser.add_argument("--cameras", choices=("rendered", "ideal"))
    parser.add_argument("--held-out", type=int, default=50)
    parser.add_argument("--try-on", help="backend of held-out episodes [that of learning]")
    parser.add_argument("--try-with", choices=("rendered", "ideal"), help="their cameras")
    options = parser.parse_args()
    folder: Path = options.folder.resolve()
    for part in ("robots", "programs"):
        shutil.copytree(shipped() / part, folder / part, dirs_exist_ok=True)
    (folder / "knowledge" / "policies").mkdir(parents=True, exist_ok=True)
    taken = {}
    for skill in SKILLS:
        taken[skill.name] = learned(folder, skill, options)
        print(json.dumps({"skill": skill.name, **taken[skill.name]}), flush=True)
    total = {
        key: round(sum(each[key] for each in taken.values()), 1) for key in taken["reachtouch"]
    }
    print(json.dumps({"skill": "all", **total}), flush=True)
    if options.held_out:
        for skill in SKILLS:
            rewarded = held_out(folder, skill, options)
            where = " ".join(each for each in _tried(options) if each)
            row = {"skill": skill.name, "tried_on": where, "rewarded": rewarded}
            print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
