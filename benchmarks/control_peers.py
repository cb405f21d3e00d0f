"""One tick of the same inverse kinematics with this package and with other libraries.

Two arms of seven joints have three tasks: a reach with one hand, the manipulability of that arm,
and a posture of both arms, with joint limits. All libraries get the same URDF, postures and goals.
A library without manipulability solves less, and the output says so. Weights replace priorities in
libraries that have none.

This package is timed twice. The first row covers joint positions to joint references, with the
predicates of a running program. The second covers the whole control cycle of Dexter
(``control_cycle.py``).

Each library solves every posture twice: in blocks of several ticks, and tick by tick in turn with
all others. Blocks correspond to a robot, because its control loop runs the same code on the same
data, which stay in the processor's caches. In single turns each library first has to load its code
and data again. This takes a larger part of a short tick than of a long one.

A library that needs other versions runs in a process of its own, on the same core, with the
interpreter named by ``--python``. It takes part in blocks only. placo needs an environment such as
``python -m venv placo && placo/bin/pip install placo "cmeel-boost==1.87.*" "cmeel-urdfdom<5"
"cmeel-tinyxml2<11"``. A library that cannot be imported is reported with the reason. The benchmark
takes one or two minutes.

With ``--rest``, all solve the same target out of reach of a planar arm instead
(``resting_peers.py``). A row gives the distance beyond the least possible one, and the largest
motion of a joint in the last of 15 s.

    python benchmarks/control_peers.py --python placo=placo/bin/python
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from ours import PATH_STAGES, ROOT, DexterCycle, TwoArms, law_with_hessians
from peer_process import RemotePeer, remote_peers
from peers import PEERS, PERIOD, Peer, Scene, load
from resting_peers import GAIN, LINKS, TARGET, TURN, remote_rest_of, rest_of, settle
from stopwatch import Stopwatch

from cbdsl.numeric.arrays import Floats

DOCUMENTS = Path(__file__).parent / "two_arms"


@contextmanager
def two_arms() -> Iterator[Path]:
    """Yield a folder with the documents, and Dexter's model with only the arms' joints movable."""
    tree = ElementTree.parse(ROOT / "robots" / "dexter.urdf")
    for joint in tree.getroot().iter("joint"):
        if "arm" not in joint.attrib["name"]:
            joint.attrib["type"] = "fixed"
            for mimic in joint.findall("mimic"):
                joint.remove(mimic)
    with tempfile.TemporaryDirectory() as folder:
        for document in DOCUMENTS.glob("*.yaml"):
            (Path(folder) / document.name).write_text(document.read_text("utf-8"), "utf-8")
        tree.write(Path(folder) / "two_arms.urdf")
        yield Path(folder)


def dexter() -> Peer:
    """Return the whole control cycle of Dexter: six levels, from sensors to predicates."""
    cycle = DexterCycle.of("reachtouch")
    cycle.restart()
    return Peer("cbdsl Dexter", cycle.tick, "Dexter, six levels", lambda q: cycle.following())


def gather(
    scene: Scene, pythons: Mapping[str, str], processes: ExitStack
) -> tuple[list[Peer], list[RemotePeer], dict[str, str]]:
    """Return the peers in this process and in others, and the reasons for missing libraries."""
    local: list[Peer] = []
    remote: list[RemotePeer] = []
    missing = {}
    for module in PEERS:
        try:
            if module in pythons:
                context = remote_peers(module, pythons[module], scene)
                remote += processes.enter_context(context)
            else:
                local += load(module, scene)
        except ImportError as error:
            missing[module] = str(error)
    return local, remote, missing


def interleaved(
    peers: Sequence[Peer | RemotePeer], postures: list[Floats], rounds: int, block: int
) -> dict[str, float]:
    """Return median times, us, by name; all solve a block of postures, in any order."""
    times: dict[str, list[float]] = {peer.name: [] for peer in peers}
    rng = np.random.default_rng(1)
    for number in range(rounds + 1):
        for start in range(0, len(postures), block):
            # A fixed order would let each peer always run after the same other one, whose data fill
            # the caches.
            for turn in rng.permutation(len(peers)):
                block_times = peers[turn].times(postures[start : start + block])
                if number:  # the first round warms up
                    times[peers[turn].name] += block_times
    return {name: round(statistics.median(values), 1) for name, values in times.items()}


def table(mode: str, medians: dict[str, float], solves: dict[str, str]) -> list[str]:
    """Return lines of medians, also as parts of Pink's fastest solver, if there is one."""
    fastest = min((time for name, time in medians.items() if "pink" in name), default=math.nan)
    lines = [f"{mode}: median of a tick, and per that of Pink's fastest solver"]
    for name, time in medians.items():
        lines.append(f"  {name:16}{time:7.0f} us {time / fastest:6.2f}   {solves[name]}")
    return lines


def split(tick: Callable[[Floats], object], postures: list[Floats]) -> dict[str, float]:
    """Return the median times of our stages, us, with the clocks' own share."""
    times: dict[str, list[float]] = {stage: [] for stage in PATH_STAGES}
    with Stopwatch(PATH_STAGES) as watch:
        for q in postures:
            watch.seconds.clear()
            tick(q.copy())
            for stage, seconds in watch.seconds.items():
                times[stage].append(seconds * 1e6)
    return {stage: round(statistics.median(values), 1) for stage, values in times.items()}


def at_rest() -> Callable[[Floats], Floats]:
    """Return the law at the target of ``resting_peers``."""
    fraction = 0.5 * GAIN * PERIOD
    solve, flat = law_with_hessians((2, 1, 3), fraction, curved=True), np.zeros((3, 3, 3))

    def tick(q: Floats) -> Floats:
        # Planar arm in complex numbers: the lever i is the vector from joint i to the tip,
        #     lever_i = sum over k >= i of l_k exp(j angle_k),
        #     d tip / d q_i = j lever_i,   d^2 tip / (d q_i d q_k) = -lever_max(i, k).
        angles = np.cumsum(q)
        levers = np.cumsum((LINKS * np.exp(1j * angles))[::-1])[::-1]
        outer = levers[np.maximum.outer(np.arange(3), np.arange(3))]
        rows, hessian = np.array([-levers.imag, levers.real]), np.array([-outer.real, -outer.imag])
        away = fraction * (TARGET[:2] - (levers[0].real, levers[0].imag))
        away *= min(1.0, 0.35 * PERIOD / float(np.linalg.norm(away)))
        turn = np.clip(np.array([fraction * (TURN - angles[-1])]), -1.5 * PERIOD, 1.5 * PERIOD)
        bend = np.clip(-fraction * q, -0.8 * PERIOD, 0.8 * PERIOD)
        levels = [(rows, away, hessian), (np.ones((1, 3)), turn, flat[:1]), (np.eye(3), bend, flat)]
        return solve(levels, q).copy()

    return tick


def rest(pythons: Mapping[str, str]) -> dict[str, dict[str, float]]:
    """Return the results of all at a target out of reach, by name; report missing libraries."""
    results = {"cbdsl": settle(at_rest())}
    for module in PEERS:
        try:
            known = module in pythons
            results |= remote_rest_of(module, pythons[module]) if known else rest_of(module)
        except ImportError as error:
            sys.stderr.write(f"{module} is missing: {error}\n")
    return results


def write_rest(pythons: Mapping[str, str], *, as_json: bool) -> None:
    """Print a row for each library at a target out of reach."""
    for name, row in rest(pythons).items():
        values = f"{row['beyond']:8.2f} mm beyond {row['motion']:8.4f} deg a tick"
        line = json.dumps({"name": name, **row}) if as_json else f"{name:24}{values}"
        sys.stdout.write(line + "\n")


def main() -> None:
    """Time all peers and print medians and ratios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--postures", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--block", type=int, default=20, help="ticks in a row in blocks")
    parser.add_argument(
        "--python", action="append", default=[], metavar="LIBRARY=PYTHON",
        help="run a library in a process of its own, with this interpreter",
    )  # fmt: skip
    parser.add_argument("--rest", action="store_true", help="solve a target out of reach")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    pythons = dict(each.partition("=")[::2] for each in options.python)
    if unknown := set(pythons) - set(PEERS):
        parser.error(
            f"--python: no library {', '.join(sorted(unknown))} (known: {', '.join(PEERS)})"
        )
    if options.rest:
        write_rest(pythons, as_json=options.json)
        return
    if pythons and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])  # for the processes as well
    rng = np.random.default_rng(0)
    with two_arms() as folder, ExitStack() as processes:
        ours = TwoArms(folder, PERIOD)
        scene = Scene(folder / "two_arms.urdf", ours.ready)
        peers, remote, missing = gather(scene, pythons, processes)
        local = [Peer("cbdsl", ours.tick, "strict priorities"), dexter(), *peers]
        # The others refuse to start outside limits.
        around = ours.ready + rng.uniform(-0.3, 0.3, (options.postures, len(ours.ready)))
        postures = list(np.clip(around, ours.lower + 0.05, ours.upper - 0.05))
        modes = {
            "in blocks": interleaved([*local, *remote], postures, options.rounds, options.block),
            "in turn": interleaved(local, postures, options.rounds, 1),
        }
        stages = split(ours.tick, postures * options.rounds)
    if options.json:
        result = {"microseconds": modes, "split": stages, "missing": missing}
        sys.stdout.write(json.dumps(result) + "\n")
        return
    every: list[Peer | RemotePeer] = [*local, *remote]
    solves = {peer.name: peer.solves for peer in every}
    lines = [f"  {name} is missing: {reason}" for name, reason in missing.items()]
    for mode, medians in modes.items():
        lines += table(mode, medians, solves)
    parts = ", ".join(f"{stage} {time:.0f}" for stage, time in stages.items())
    lines.append(f"cbdsl, with clocks in it: {parts} us")
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
