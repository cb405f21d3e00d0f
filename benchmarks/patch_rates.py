"""Rates of success before and after the patches that ``cb why --try`` offers, on fresh seeds.

``python benchmarks/patch_rates.py`` damages shipped programs and lets ``cb why`` offer a patch for
the first failed seed. Both programs then run on 20 seeds that no trial has used.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from first_causes import written

from cbdsl.numeric.proportion import exact_interval


class Damage(NamedTuple):
    """Damage of a program.

    Attributes:
        name: Name of the damage.
        program: Name of the program.
        before, after: Text of the program, and its replacement.
        backend: Name of the backend; empty for that of the command.
    """

    name: str
    program: str
    before: str
    after: str
    backend: str = ""


# The last eight were written before the rules of patches were final, and not tried before.
DAMAGES = (
    Damage("short actions", "reach", "transition_time: 15", "transition_time: 1"),
    Damage(
        "short episodes",
        "pick_and_lift",
        "limits: {transitions: 60, transition_time: 15 s, episode_time: 90 s, reward_ends: false}",
        "limits: {transitions: 60, transition_time: 15 s, episode_time: 6 s, reward_ends: false}",
    ),
    Damage(
        "few transitions",
        "pick_and_lift",
        "limits: {transitions: 60, transition_time: 15 s, episode_time: 90 s, reward_ends: false}",
        "limits: {transitions: 4, transition_time: 15 s, episode_time: 90 s, reward_ends: false}",
    ),
    Damage(
        "a wrong exit",
        "pick_and_lift",
        "exits: [grip at rest: lift]",
        "exits: [grip at rest: ease]",
    ),
    Damage(
        "short transitions",
        "take_and_put_down",
        "transition_time: 15 s",
        "transition_time: 1 s",
        "mujoco",
    ),
    Damage(
        "a slow slide",
        "press_and_slide",
        "    speed: 4 cm/s\n    acceleration: 0.3 m/s^2\n",
        "    speed: 1 mm/s\n    acceleration: 0.3 m/s^2\n",
    ),
    Damage(
        "an exit to an earlier step",
        "twist",
        "turn at rest and track undefined: there_upright",
        "turn at rest and track undefined: settle",
    ),
    Damage("little gain", "touch_table", "    gain: 2 /s\n", "    gain: 0.02 /s\n"),
    Damage("a strict guard", "bimanualgrab", "limits: {", "guards: {hand_force: 4 N}\nlimits: {"),
    Damage(
        "a long window", "press_and_slide", "rate: 0.5, window: 0.5 s", "rate: 0.5, window: 12 s"
    ),
    Damage(
        "a weak hold", "pick_and_place", "hold($hand, $hand.hold,", "hold($hand, 0.3 N,", "mujoco"
    ),
    Damage("a short handover", "handover", "episode_time: 120 s", "episode_time: 16 s"),
    Damage("a weak grasp", "bring", "force: 8 N}", "force: 0.5 N}", "mujoco"),
    Damage("a weak squeeze", "bimanualgrab", "squeeze(10 N, 1.5 s)", "squeeze(0.3 N, 1.5 s)"),
    Damage("a long squeeze", "bimanualgrab", "squeeze(10 N, 1.5 s)", "squeeze(10 N, 60 s)"),
    Damage(
        "a weak touch of one of two hands",
        "bimanualtouch",
        "hold_still(right_hand, 6 N",
        "hold_still(right_hand, 0.1 N",
    ),
    Damage("a slow lift", "take_and_put_down", "15 cm, 15 cm/s", "15 cm, 2 mm/s", "mujoco"),
    Damage("a slow lift of a carried object", "bring", "12 cm, 12 cm/s", "12 cm, 1 mm/s", "mujoco"),
    Damage(
        "little gain of a descent",
        "set_on",
        "set_down($arm, $hand, hold, 2 N, 2 /s)",
        "set_down($arm, $hand, hold, 2 N, 0.02 /s)",
        "mujoco",
    ),
    Damage(
        "little gain of a press",
        "twist",
        "bear_on($arm, $hand, $press, 2 /s)",
        "bear_on($arm, $hand, $press, 0.02 /s)",
    ),
    Damage("a slow way", "handover", "speed: 25 cm/s", "speed: 2 mm/s"),
    Damage("a weak grip", "show_ball", "4 N along", "0.2 N along", "mujoco"),
    Damage(
        "a long rest", "transport_hand", "rate: 0.05, window: 0.3 s", "rate: 0.05, window: 30 s"
    ),
    Damage("a slow turn", "visualinspect", "0.15 rad/s", "0.005 rad/s"),
    Damage(
        "little gain of a press of two hands",
        "reachtouch_bimanual",
        "gain: 2 mm/s/N",
        "gain: 0.02 mm/s/N",
    ),
    Damage(
        "a weak grasp of two hands",
        "bring_with_both",
        "force: 20 N, most",
        "force: 1 N, most",
        "mujoco",
    ),
    Damage("a slow descent", "take_from_side", "speed: 12 cm/s", "speed: 2 mm/s", "mujoco"),
    Damage("little gain of a way", "touch_remembered", "gain: 2 /s", "gain: 0.01 /s"),
)


def _cb(*words: str) -> list[dict[str, object]]:
    """Return the JSON rows that a command prints."""
    done = subprocess.run(
        [str(Path(sys.executable).with_name("cb")), *words], capture_output=True, text=True
    )
    rows = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    if not rows:
        print(done.stderr, file=sys.stderr)
    return rows


def _rate(program: str, backend: str, seeds: range) -> int:
    """Return the number of successes of a program on some seeds."""
    options = ("--backend", backend, "--cameras", "ideal", "--json")
    words = ("--seed", str(seeds.start), "--episodes", str(len(seeds)))
    return sum(bool(row.get("succeeded")) for row in _cb("run", program, *options, *words))


def main() -> None:
    """Print a row for each damage."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--seed", type=int, default=1200, help="Seed of the explained failure.")
    parser.add_argument("--only", help="Name of one damage [all].")
    options = parser.parse_args()
    seeds = range(options.seed + 2000, options.seed + 2020)
    for damage in DAMAGES:
        if options.only not in (None, damage.name):
            continue
        backend = damage.backend or options.backend
        edits = {damage.program: [(damage.before, damage.after)]}
        with TemporaryDirectory() as folder:
            program = str(written(edits, Path(folder), damage.program))
            words = ("--backend", backend, "--cameras", "ideal", "--json", "--apply")
            before = _rate(program, backend, seeds)
            (row,) = _cb("why", program, *words, "--seed", str(options.seed))
            patch, cause = row.get("patch"), row["cause"]
            line = {"damage": damage.name, "failed": row["failed"], "before": before}
            line["cause"] = cause["kind"] if isinstance(cause, dict) else None
            if isinstance(patch, dict):
                after = _rate(program, backend, seeds)
                low, high = exact_interval(after, len(seeds))
                line |= {"edit": patch["edit"], "after": after, "interval": [low, high]}
            print(json.dumps(line, ensure_ascii=False), flush=True)


if __name__ == "__main__":
    main()
