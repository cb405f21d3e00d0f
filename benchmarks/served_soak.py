"""Memory of a served robot and of a program that drives it, for hours.

Two processes run as a user starts them: ``cb drive serve`` and ``cb run --backend ros2``, which
tracks an object in one episode after another. A third process listens to the joint states for ten
seconds of each minute, as tools that come and go do. A row a minute holds the memory of both
processes in MB: anonymous pages, which files on disk do not share. A held program is started again,
and its last line is kept.

    python benchmarks/served_soak.py --hours 8 [--domain 60] [--out build/soak.jsonl]
    python benchmarks/served_soak.py --summary build/soak.jsonl
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

COMMON = ("--cameras", "ideal", "--seed", "3")
SERVE = ("drive", "serve", "dexter", "--backend", "mujoco", "--stage", "table_right", *COMMON)
RUN = ("run", "searchtrack", "--backend", "ros2", "--yes", "--json", "--episodes", "100000")
_LISTENING = 10.0
# Minutes at the start of a process, in which its caches fill.
_WARMING = 10
# Least episode of a program that counts as one, for its rate of growth, in minutes.
_LEAST = 20


def start(words: Sequence[str], log: Path) -> subprocess.Popen[bytes]:
    """Start a command of ``cb``, whose output goes to a file."""
    with log.open("wb") as file:
        return subprocess.Popen(
            [str(Path(sys.executable).with_name("cb")), *words], stdout=file, stderr=file
        )


def memory(process: subprocess.Popen[bytes]) -> float:
    """Return the anonymous memory of a process, MB."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    line = next(line for line in status.splitlines() if line.startswith("RssAnon"))
    return round(int(line.split()[1]) / 1e3, 3)


def listen() -> None:
    """Read joint states for a while."""
    from cbdsl_ros2.dds_types import JointState
    from cbdsl_ros2.ros_node import RosNode

    node, until = RosNode(), time.monotonic() + _LISTENING
    reader = node.reader("/joint_states", JointState)
    while time.monotonic() < until:
        reader.take(64)
        time.sleep(0.1)


def soak(seconds: float, out: Path) -> None:
    """Run both processes, and add a row to a file each minute."""
    log = out.with_suffix(".program.log")
    served = start(SERVE, out.with_suffix(".served.log"))
    time.sleep(10.0)
    began, program, starts = time.monotonic(), start((*RUN, *COMMON), log), 1
    minute = began
    try:
        while time.monotonic() - began < seconds and served.poll() is None:
            listener = subprocess.Popen([sys.executable, __file__, "--listen"])
            row: dict[str, Any] = {"minute": round((time.monotonic() - began) / 60.0, 1)}
            if program.poll() is not None:
                row["ending"] = log.read_text(errors="replace").splitlines()[-1][:300]
                program, starts = start((*RUN, *COMMON), log), starts + 1
            row.update(served=memory(served), program=memory(program), starts=starts)
            row["episodes"] = log.read_bytes().count(b"\n")
            with out.open("a") as file:
                file.write(json.dumps(row) + "\n")
            listener.wait()
            # Rows follow the clock, so that a slow row does not delay all later ones.
            minute += 60.0
            time.sleep(max(0.0, minute - time.monotonic()))
    finally:
        for process in (program, served):
            process.terminate()
            process.wait()


def growth(minutes: Sequence[float], sizes: Sequence[float]) -> float:
    """Return the slope of a memory after its start, MB per hour."""
    return float(60.0 * np.polyfit(minutes, sizes, 1)[0])


def summary(lines: Sequence[str]) -> str:
    """Return sentences about the growth of both processes."""
    rows = [json.loads(line) for line in lines]
    late = [row for row in rows if row["minute"] >= _WARMING]
    sentences = [f"{rows[-1]['minute']:.0f} minutes, {rows[-1]['starts']} starts of the program"]
    minutes = [row["minute"] for row in late]
    sentences.append(
        f"served: {late[0]['served']:.2f} to {late[-1]['served']:.2f} MB, "
        f"{growth(minutes, [row['served'] for row in late]):+.3f} MB per hour"
    )
    for start_number in sorted({row["starts"] for row in rows}):
        # There is one row a minute.
        own = [row for row in rows if row["starts"] == start_number][_WARMING:]
        if len(own) >= _LEAST:
            slope = growth([row["minute"] for row in own], [row["program"] for row in own])
            sentences.append(
                f"program {start_number}: {own[0]['program']:.2f} to {own[-1]['program']:.2f} MB, "
                f"{slope:+.3f} MB per hour, {own[-1]['episodes']} episodes"
            )
    sentences.extend(row["ending"] for row in rows if "ending" in row)
    return "\n".join(sentences)


def main() -> None:
    """Run both processes, or print a summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, default=8.0)
    parser.add_argument("--domain", type=int, default=60)
    parser.add_argument("--out", type=Path, default=Path("build/soak.jsonl"))
    parser.add_argument("--summary", type=Path)
    parser.add_argument("--listen", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.summary:
        sys.stdout.write(summary(options.summary.read_text().splitlines()) + "\n")
    elif options.listen:
        listen()
    else:
        os.environ["ROS_DOMAIN_ID"] = str(options.domain)
        options.out.parent.mkdir(parents=True, exist_ok=True)
        soak(3600.0 * options.hours, options.out)


if __name__ == "__main__":
    main()
