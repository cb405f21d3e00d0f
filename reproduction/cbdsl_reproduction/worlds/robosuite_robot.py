"""Robot documents of robosuite's arms, proposed from its models as those of any other robot."""

from __future__ import annotations

from pathlib import Path

from cbdsl import propose_robot
from cbdsl.api.documents import write_text
from cbdsl.extend.backend import read_robot
from cbdsl_reproduction.worlds.camera_pair import CameraPair
from cbdsl_reproduction.worlds.edge_sensor import EDGES
from cbdsl_reproduction.worlds.robosuite_process import RobosuiteProcess

#: Control rate, Hz; a multiple of the period of robosuite's physics, 2 ms.
RATE = 50.0
_IMAGES = 12.5  # per second


def write_robot(name: str, process: RobosuiteProcess, cameras: CameraPair, folder: Path) -> Path:
    """Write the robot document of the arm of a task.

    Args:
        name: Name of the robot.
        process: Process with the task.
        cameras: Cameras of the robot.
        folder: Folder of the documents.

    Returns:
        File of the robot document, as ``cb new robot`` writes it, with the cameras.

    Raises:
        UsageError: The model cannot be read.
    """
    process.ask("reset", seed=0)
    model = folder / f"{name}.xml"
    write_text(process.ask("model")[0]["xml"], model)
    proposal = propose_robot(name, model, to=folder / "robots", force=True)
    text = proposal.robot.read_text(encoding="utf-8")
    pair = "\n".join(
        f"  {side}: {{link: {side}_camera, width: {cameras.width}, height: {cameras.height}, "
        f"focal_length: {cameras.focal_length:g} px}}"
        for side in cameras.places
    )
    heading = (
        "    heading: {gain: 8 /s, speed: 1 rad/s, "
        "quiescence: {rate: 1e-3, window: 0.3 s, tolerance: 5 deg}}"
    )
    hands = read_robot(proposal.robot)[0].load_cells
    edges = "\n".join(f"  edges_{hand}: {{kind: {EDGES.name}, hand: {hand}}}" for hand in hands)
    added = f"cameras:\n{pair}\n\nvision: {{rate: {_IMAGES} Hz}}\n\nsensors:\n{edges}\n"
    text = text.replace("\ncontrol:\n", f"\n{added}\ncontrol:\n", 1)
    text = text.replace("  rate: 60 Hz\n", f"  rate: {RATE:g} Hz\n", 1)
    text = text.replace("\n  tasks:\n", f"\n  tasks:\n{heading}\n", 1)
    text = text.replace("\nsimulation:\n", "\nsimulation:\n  physics_rate: 500 Hz\n", 1)
    write_text(text, proposal.robot)
    return proposal.robot
