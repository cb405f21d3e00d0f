"""Form of a recording: content of its two files, as ``Recording`` writes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidationError

from cbdsl.program.uses import of_use
from cbdsl.robot.urdf import UrdfError
from cbdsl.robot.urdf_reader import parse_urdf
from cbdsl.runtime.recording import HOLDERS, SIGHT

# Numbers in the size of a part: edges, a radius, or a radius and a height.
_SIZES = {"box": 3, "ball": 1, "cylinder": 2}

_Triple = Annotated[list[float], Field(min_length=3, max_length=3)]


# Strict models reject texts such as "1" for numbers, which pydantic would otherwise convert here
# and the page would not.
class _Result(BaseModel, strict=True):
    program: str
    stage: str
    context: str
    seed: int
    rewarded: bool
    sim_seconds: float
    ending: str
    outcome: str = ""
    far: list[str] = []
    causes: dict[str, str] = {}
    halted: bool = False
    succeeded: bool = False


class _RecordedTriple(BaseModel, strict=True):
    feedback: str
    reference: str
    effector: str = ""
    unit: str = ""
    base: str = ""
    requires: str = ""


class _Signal(BaseModel, strict=True):
    place: bool
    type: str = ""
    channels: list[str] = []
    pairs: list[str] = []


class _Limits(BaseModel, strict=True):
    transitions: int
    transition_time: float
    idle_time: float | None = None
    episode_time: float | None = None
    lost_time: float | None = None


class _Turned(BaseModel, strict=True):
    position: _Triple
    rotation: _Triple


class _Camera(BaseModel, strict=True):
    link: str
    width: int
    height: int
    focal_length: float
    correction: _Turned | None = None


class _Tip(BaseModel, strict=True):
    joint: str
    link: str
    offset: _Triple


class _Robot(BaseModel, strict=True):
    name: str
    urdf: str
    folder: str
    singular_value: float
    lead: float | None = None
    couplings: dict[str, list[str | float]]
    cameras: dict[str, _Camera] = {}
    cells: dict[str, str] = {}
    tips: dict[str, _Tip] = {}


class _Mesh(BaseModel, strict=True):
    corners: list[list[float]]
    triangles: list[list[int]]


class _Part(BaseModel, strict=True):
    shape: Literal["ball", "box", "cylinder", "mesh"]
    position: _Triple
    quaternion: Annotated[list[float], Field(min_length=4, max_length=4)]
    color: _Triple
    size: list[float]
    mesh: _Mesh = _Mesh(corners=[], triangles=[])


class _Exit(BaseModel, strict=True):
    when: str
    to: str
    letters: dict[str, str]


class _Step(BaseModel, strict=True):
    step: str
    action: str
    program: str
    exits: list[_Exit]


class _Automaton(BaseModel, strict=True):
    members: list[str]
    start: str
    steps: list[_Step]
    kinds: dict[str, Literal["program", "condition"]]
    compared: dict[str, list[list[str | int]]]
    reward_ends: bool


class _Transition(BaseModel, strict=True):
    program: str
    depth: int
    time: float
    state: str
    action: str
    next_state: str
    ticks: int
    reward: float
    rewarding: list[str] = []
    allocation: str = ""
    features: dict[str, float] = {}
    use: str = ""
    reason: str = ""
    stuck: list[str] = []


class _Summary(BaseModel, strict=True):
    result: _Result
    source: list[str] = ["", ""]
    shared: dict[str, str] = {}
    joints: list[str]
    controllers: list[str]
    load_cells: list[str]
    guards: list[str] = []
    predicates: list[str]
    transitions: list[_Transition]
    members: dict[str, list[str]]
    limits: dict[str, _Limits] = {}
    leads: dict[str, str] = {}
    automata: dict[str, _Automaton] = {}
    channels: list[str] = []
    triples: dict[str, _RecordedTriple]
    signals: dict[str, _Signal]
    scene: dict[str, list[_Part]]
    robot: _Robot


def summary_faults(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield faults in a recording's JSON file, as clauses; the first is the cause."""
    try:
        _Summary.model_validate(summary)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"]))
        yield f"{where}: {first['msg'][:1].lower()}{first['msg'][1:]}"
        return
    yield from _robot_faults(summary)
    controllers = summary["controllers"]
    if set(summary["triples"]) != set(controllers):
        yield "triples: are not those of the controllers"
    if not summary["predicates"]:
        yield "predicates: there are none"
    if any(len(each) != len(controllers) for each in summary["predicates"]):
        yield "predicates: have not one letter for each controller"
    yield from _transition_faults(summary)
    for parts in summary["scene"].values():
        yield from (fault for part in parts for fault in _part_faults(part))


def _transition_faults(summary: Mapping[str, Any]) -> Iterator[str]:
    automata = summary.get("automata", {})
    for each in summary["transitions"]:
        program, use = each["program"], each.get("use", "")
        states = (each["state"], each["next_state"])
        members = of_use(summary["members"], program, use) or ()
        if any(len(state) != len(members) for state in states):
            yield "transitions: have not one letter for each member"
        automaton = of_use(automata, program, use)
        if automaton is not None and automaton["members"] != members:
            yield f"automata: {program} has other members than its program"
    for name, automaton in automata.items():
        letters = (each["letters"] for step in automaton["steps"] for each in step["exits"])
        if any(each.keys() - set(automaton["members"]) for each in letters):
            yield f"automata: {name} has an exit of a member that it lacks"


def _robot_faults(summary: Mapping[str, Any]) -> Iterator[str]:
    robot = summary["robot"]
    for name, pair in robot["couplings"].items():
        has_numbers = len(pair) in (2, 3) and all(isinstance(n, int | float) for n in pair[1:])
        if not has_numbers or pair[0] not in summary["joints"]:
            yield f"robot.couplings.{name}: is not a recorded joint with a ratio"
    try:
        bodies = parse_urdf(robot["urdf"], Path("robot.urdf")).bodies
    except UrdfError as error:
        yield f"{error}"
        return
    for name, tip in robot.get("tips", {}).items():
        if tip["link"] not in bodies or tip["joint"] not in summary["joints"]:
            yield f"robot.tips.{name}: is not on a recorded joint and link"


def _part_faults(part: Mapping[str, Any]) -> Iterator[str]:
    lengths = _SIZES.get(part["shape"])
    if lengths is not None and len(part["size"]) != lengths:
        yield f"scene: a {part['shape']} has {len(part['size'])} sizes instead of {lengths}"
    if "mesh" not in part:
        return
    corners, triangles = part["mesh"]["corners"], part["mesh"]["triangles"]
    if any(len(each) != 3 for each in (*corners, *triangles)):
        yield "scene: a mesh has corners or triangles of other than three numbers"
    elif any(not 0 <= index < len(corners) for each in triangles for index in each):
        yield "scene: a mesh has a triangle without a corner"


def array_faults(summary: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Iterator[str]:
    """Yield faults in the arrays of a recording whose summary is sound, as clauses."""
    for name, array in arrays.items():
        wanted = _shape(name, summary, arrays)
        if wanted is None:
            continue
        own = array.shape
        if len(own) != len(wanted) or any(
            b not in (-1, a) for a, b in zip(own, wanted, strict=True)
        ):
            yield f"{name}: has the shape {own}"
        elif array.dtype.kind not in (
            "u" if name.startswith("image_") and len(own) == 4 else "fiub"
        ):
            yield f"{name}: is of {array.dtype}"
    count, signals = len(summary["controllers"]), summary["signals"].items()
    for name, what, end in (
        *((f"pair_{name}", "pair", len(each.get("pairs", ()))) for name, each in signals),
        ("level_held_by", "controller", count + len(HOLDERS)),
        ("sight", "kind of sight", len(SIGHT)),
    ):
        codes = arrays.get(name, np.zeros(0))
        if codes.min(initial=0) < -1 or codes.max(initial=-1) >= end:
            yield f"{name}: names a {what} that is not there"


def _shape(
    name: str, summary: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
) -> tuple[int, ...] | None:
    """Return the shape of an array, -1 for any length, or ``None`` for an unknown array."""
    joints, controllers = len(summary["joints"]), len(summary["controllers"])
    if name in ("time", "image_time") or name.startswith("pair_"):
        return (-1,)
    if name.startswith("image_"):
        return (arrays["image_time"].size, -1, -1, 3)
    if name.startswith("level_") or name in ("potentials", "errors", "flags"):
        return (-1, controllers)
    cells = len(summary["load_cells"])
    return {
        "positions": (-1, joints),
        "references": (-1, joints),
        "velocities": (-1, joints),
        "at_limits": (-1, joints),
        "scene": (-1, len(summary["scene"]), 7),
        "loads": (-1, cells, 6) if cells else (-1, 0),
        "guard_held": (-1, len(summary.get("guards", []))),
        "sight": (-1, len(summary.get("channels", []))),
    }.get(name)
