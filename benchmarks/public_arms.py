"""Public arms without edits: ``cb new robot --cameras``, then ``reach``, judged by the truth.

The models come from the packages ``pybullet_data``, part of PyBullet, and ``example-robot-data``
(``pip install --no-deps example-robot-data``). An episode is right if the tip rests within
5 cm of the sphere around the object, and the object has moved by 2 cm at most. No value of the
proposed document counts. A wrong arm has its most frequent causes.

    python benchmarks/public_arms.py [--only panda,ur] [--episodes 3] [--backend mujoco] [--json]
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from public_models import folder_of

ARMS = {
    "pybullet_data": """
        franka_panda/panda kuka_iiwa/model xarm/xarm6_robot xarm/xarm6_with_gripper
    """,
    "example-robot-data": """
        b1_description/urdf/b1-z1 baxter_description/urdf/baxter kinova_description/robots/kinova
        panda_description/urdf/panda pr2_description/urdf/pr2 romeo_description/urdf/romeo_small
        so_arm_description/urdf/so100 so_arm_description/urdf/so101
        talos_data/robots/talos_left_arm talos_data/robots/talos_reduced
        tiago_description/robots/tiago tiago_description/robots/tiago_no_hand
        tiago_pro_description/robots/tiago_pro ur_description/urdf/ur3_robot
        ur_description/urdf/ur5_robot ur_description/urdf/ur5_gripper
        ur_description/urdf/ur10_robot xarm_description/urdf/xarm7 z1_description/urdf/z1
        alex_description/urdf/alex_nub_hands
    """,
}
# Greatest distance of a tip from the sphere around its object, and way of that object, m.
NEAR, STAYS = 0.05, 0.02


def arms() -> Iterator[tuple[str, Path | None]]:
    """Yield all arms by name, with their files if the package is installed."""
    for package, names in ARMS.items():
        folder = folder_of(package)
        for name in names.split():
            yield f"{package}: {name}", folder and folder / f"{name}.urdf"


def reaching(urdf: Path, backend: str, episodes: int) -> dict[str, Any]:
    """Propose a robot for a model, and let it reach."""
    import cbdsl
    from cbdsl.diagnostics.errors import DiagnosticsError, UsageError

    began = time.monotonic()
    with TemporaryDirectory() as place:
        folder = Path(place)
        try:
            cbdsl.propose_robot("public", urdf, to=folder / "robots", cameras=True)
            request = cbdsl.load("reach", values={"robot": "public"}, folder=folder)
            with cbdsl.simulate(request, backend=backend, cameras="ideal") as world:
                causes = [why(world, request, seed) for seed in range(1, episodes + 1)]
        except (DiagnosticsError, UsageError) as error:
            return {"right": 0, "of": episodes, "why": str(error).replace(f"{folder}/", "")}
    wrong = Counter(cause for cause in causes if cause)
    return {
        "right": causes.count(""),
        "of": episodes,
        "why": "; ".join(f"{count} x {cause}" for cause, count in wrong.most_common(2)),
        "seconds": round(time.monotonic() - began, 1),
    }


def why(world: Any, request: Any, seed: int) -> str:
    """Return why an episode is wrong; empty if it is right."""
    arm = request.program.parameters["arm"]
    seen: dict[str, Any] = {}

    def note(tick: Any) -> None:
        name = next((n for n in world.truth.objects if n in request.stage.things), None)
        if name is not None:
            seen.setdefault("first", np.array(world.truth.position(name)))
            seen["object"] = np.array(world.truth.position(name))
            seen["size"] = float(np.linalg.norm(world.truth.half_extents(name)))
        seen["tip"] = np.array(tick.signals.tips.point(arm).position)

    result = world.robot.run(seed, on_tick=note)
    if "object" not in seen:
        return "no object"
    if not result.ending.startswith("Done"):
        return str(result.ending).split(": ")[-1]
    off = float(np.linalg.norm(seen["tip"] - seen["object"]))
    if off > seen["size"] + NEAR:
        return f"{100 * off:.0f} cm off the object"
    moved = float(np.linalg.norm(seen["object"] - seen["first"]))
    return f"pushed the object {100 * moved:.0f} cm" if moved > STAYS else ""


def main() -> None:
    """Print a table of all arms."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="parts of names, with commas between them")
    parser.add_argument("--episodes", type=int, default=3)
    parser.add_argument("--backend", default="mujoco")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    for name, urdf in arms():
        if not any(part in name for part in given.only.split(",")):
            continue
        row: dict[str, Any] = {"right": 0, "of": given.episodes, "why": "not installed"}
        if urdf is not None:
            row = reaching(urdf, given.backend, given.episodes)
        if given.json:
            print(json.dumps({"arm": name, **row}), flush=True)
        else:
            print(
                f"| {name} | {row['right']} of {row['of']} | {row['why'] or 'right'} |", flush=True
            )


if __name__ == "__main__":
    main()
