"""Programs that push by the shipped network: guarded, bare, or behind a filter of others."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

from cbdsl import RunRequest, load
from cbdsl.api.documents import write_text
from cbdsl.api.shipped import shipped_program
from cbdsl.extend.document import compose
from cbdsl_reproduction.guarded.scene import TABLE, drawn_scene, stage_of

PROGRAM = "push_by_network"
# Share of random actions, and their largest speed.
_RANDOM = {"share": 0.1, "speed": "20 cm/s"}
#: Controllers of the network.
NETWORK = ("policy", "again")
# Written step after the network.
_LAST = "withdraw"


class PushSetting(NamedTuple):
    """Setting of a condition.

    Attributes:
        is_guarded: True for the guards and bounds of the shipped program.
        is_alone: True without the written steps that take over from the network.
        filter: Name of the modifier that filters the references of the palm; empty for none.
        has_table: True if the table is an obstacle for the filter, too.
        is_clean: True without obstacles, pushes, noise and random actions.
    """

    is_guarded: bool = False
    is_alone: bool = True
    filter: str = ""
    has_table: bool = False
    is_clean: bool = False


def request_of(setting: PushSetting, seed: int, folder: Path) -> RunRequest:
    """Write the program and the stage of an episode to a folder, and load them.

    Args:
        setting: Setting of the condition.
        seed: Seed of the scene and of the random actions.
        folder: Folder for the documents.
    """
    shipped, scene = shipped_program(PROGRAM), drawn_scene(seed)
    program: Any = compose(shipped.program_file.read_text("utf-8"), PROGRAM).root.plain()
    program["name"], program["stage"] = "guarded_push", "guarded"
    if setting.is_alone:
        _leave_alone(program)
    if setting.is_guarded:
        avoided = () if setting.is_clean else scene.obstacles
        program["guards"]["avoid"] = [TABLE, *avoided]
    else:
        _leave_bare(program)
    paces = dict.fromkeys(NETWORK, 1.0)
    paces[_LAST] = shipped.program.primitives[_LAST].lead.gain / 2.0
    for name, pace in paces.items():
        if name in program["controllers"]:
            program["controllers"][name]["modifiers"] = _modifiers(setting, seed, name, pace)
    stage = stage_of(scene, shipped.stage, is_clean=setting.is_clean)
    for document in (program, stage):
        text = json.dumps(document, indent=1, ensure_ascii=False)
        write_text(f"{text}\n", folder / f"{document['name']}.yaml")
    return load(folder / "guarded_push.yaml")


def _modifiers(setting: PushSetting, seed: int, name: str, pace: float) -> dict[str, Any]:
    modifiers: dict[str, Any] = {}
    if name in NETWORK and not setting.is_clean:
        modifiers["random_actions"] = {**_RANDOM, "seed": seed}
    if setting.filter:
        modifiers[setting.filter] = {"pace": f"{pace} /s"}
    if setting.filter == "barrier":
        modifiers["barrier"] |= {"scene": seed, "table": int(setting.has_table)}
    return modifiers


def _leave_alone(program: dict[str, Any]) -> None:
    """Remove all written steps but those before and after the network."""
    steps = program["steps"]
    for name in ("above", "behind", "again", "push"):
        del steps[name]
    program["steps"] = steps | {
        "policy": {
            **steps["policy"],
            "exits": [{"arrived": _LAST}, {"policy undefined or policy at rest": _LAST}],
        },
        "verify": {
            "exits": [{"verify succeeded and there": "succeed"}, {"verify succeeded": "fail"}],
            "failed": "fail",
        },
    }
    del program["conditions"]["withheld"]
    for name in ("above", "behind", "again", "push", "straight"):
        del program["controllers"][name]


def _leave_bare(program: dict[str, Any]) -> None:
    """Remove the guards, and the bounds above the network."""
    bounds = ("keep_out", "keep_in", "force")
    for step in program["steps"].values():
        if "do" in step:
            levels = step["do"].split(" ◁ ")
            step["do"] = " ◁ ".join(level for level in levels if level not in bounds)
    for name in bounds:
        del program["controllers"][name]
    del program["guards"]
