"""Recordings: sensed signals, references and conclusions of a run, kept for later viewing."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.backends.staging.world_state import Part, WorldState
from cbdsl.documents.robot import RobotDocument
from cbdsl.program.checked import CheckedProgram, resources_of
from cbdsl.program.controller import AlongNormals, Controller, Literal, Relative
from cbdsl.program.transition import Transition
from cbdsl.program.uses import by_use
from cbdsl.robot.joints import Joints
from cbdsl.robot.meshes.simplified_mesh import simplified
from cbdsl.runtime.causes import CLEARANCE, LIMITS, OPTIMUM, SINGULAR
from cbdsl.runtime.controllers.controller_run import ControllerRun
from cbdsl.runtime.episode_observer import EpisodeObserver
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.explanation import Explanation, LevelExplanation, named_runs
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.runtime.recording_folder import RecordingFolder
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.signals import Signals
from cbdsl.sensing.vision.memory.instances import Instances
from cbdsl.storage.atomic_file import replace_file, write_text
from cbdsl.types.resource import Centroid, LinkDistance, Resource, StereoPosition, Tip
from cbdsl.types.source_record import channels_of, sources_of

#: Version of the files; raised if a reader of older files would be misled.
VERSION = 2

# Half of the images' width is enough to show the events.
_THUMBNAIL_SCALE = 0.5

# Number of pairs of links kept apart that are recorded, those for longest.
_MOST_PAIRS = 6

# An orientation is a rotation matrix and a pose a homogeneous transform; the rest are vectors.
_SHAPES = {"orientation": (3, 3), "pose": (4, 4)}

# Sources of positions that can be shown in the world; other sources are their differences.
_PLACES = (Tip, Centroid, StereoPosition)

#: Recorded numbers of a level and their types.
_LEVEL = {
    "level_priority": np.int8,
    "level_share": np.float32,
    "level_rank": np.int8,
    "level_singular_value": np.float32,
    "level_predicted": np.float64,
    "level_held_by": np.int16,
}
_ABSENT = (-1, np.nan, 0, np.nan, np.nan, -1)

#: Holders whose recorded indices follow those of the controllers.
HOLDERS = (LIMITS, OPTIMUM, SINGULAR, CLEARANCE)

#: Recorded facts of a controller, one bit each, the lowest first.
FLAGS = ("seeking", "exhausted", "astray", "stuck", "lacks_hold")
#: Sight of a channel's object: in no image and not remembered, in the images of one camera alone,
#: in all images without a position, remembered but in no image with and without an explanation,
#: seen, seen beside others, and once in each image but at no common position.
SIGHT = ("unseen", "partly", "ambiguous", "hidden", "missing", "seen", "several", "unmatched")


class Recording(EpisodeObserver):
    """Recorder of one episode into two files: numbers as NPZ, the rest as JSON.

    The NPZ holds, per control tick:

    - ``time``, s.
    - ``positions`` and ``references`` of the actuated joints, rad (T, n), their ``velocities``,
      rad/s (T, n), and ``at_limits`` (T, n) as in ``LevelExplanation``.
    - ``potentials`` and ``errors`` (T, c), NaN while undefined, and ``level_...`` (T, c) as in
      ``LevelExplanation``.
    - ``flags`` (T, c) of ``FLAGS``, and ``sight`` (T, channels), indices of ``SIGHT``.
    - ``loads``, N and N m (T, cells, 6).
    - ``signal_<resource>``: value of each resource in SI (T, ...), NaN while undefined.
    - ``pair_<distance>`` (T,): nearest links, an index into the ``pairs`` of the signal.
    - ``scene`` (T, bodies, 7): true position, m, and quaternion (x, y, z, w) of each body, NaN
      while it is not in the world.

    Per image it holds ``image_time`` and ``image_<camera>``.

    Args:
        program: Program that runs; its samples are not recorded as signals.
        robot: Robot that it runs on.
        urdf: Path of the robot's URDF model.
        scenery: Function that returns the state of the world, for display only.
        source: File and digest of the program, and digests of the shared documents that it takes
            up, by which a later change is noticed.
        automata: Steps and exits of the programs by name, as data.
    """

    def __init__(
        self,
        program: CheckedProgram,
        robot: RobotDocument,
        urdf: Path,
        scenery: Callable[[], WorldState] | None = None,
        source: tuple[str, str, Mapping[str, str]] = ("", "", MappingProxyType({})),
        automata: Mapping[str, object] = MappingProxyType({}),
    ) -> None:
        self._source, self._automata = source, automata
        self._program, self._robot, self._urdf = program, robot, urdf
        self._joints = Joints(robot).names
        self._resources = [each for each in resources_of(program) if not each.is_drawn]
        self._rows: dict[str, list[Any]] = {
            key: []
            for key in (
                "time", "positions", "velocities", "references", "potentials", "errors", "loads",
                "flags", "sight", "guard_held",
                *(f"signal_{each.name}" for each in self._resources),
            )
        }  # fmt: skip
        self._distances = [e for e in self._resources if sources_of([e], LinkDistance)]
        self._rows |= {f"pair_{each.name}": [] for each in self._distances}
        # Nearest links of each distance, by their names.
        self._pairs = {each.name: {"": 0} for each in self._distances}
        self._guards: list[str] = []
        self._apart: list[tuple[str, ...]] = []
        self._explanation = Explanation()
        self._levels: list[list[tuple[float, ...]]] = []
        self._at_limits: list[list[bool]] = []
        self._scenery = scenery
        self._bodies: dict[str, tuple[Part, ...]] = {}
        self._poses: list[dict[str, list[float]]] = []
        self._images: dict[str, list[Any]] = {}
        self._image_time: list[float] = []
        self._predicates: list[str] = []
        self._transitions: list[Transition] = []
        self._controllers: dict[str, Controller] = {}
        self._cells: tuple[str, ...] = ()
        self._channels: tuple[str, ...] = ()
        self._leads: dict[str, str] = {}
        self._settings: Any = robot.control
        self._ticks = 0

    @property
    def ticks(self) -> int:
        """Number of control ticks that are recorded completely."""
        return self._ticks

    def note_transition(self, transition: Transition) -> None:
        """Keep a transition."""
        self._transitions.append(transition)

    def note_tick(self, tick: Tick) -> None:
        """Keep a control tick."""
        runs = list(named_runs(tick.run))
        observation = tick.observation
        self._controllers = {name: run.controller for name, run in runs}
        if not self._leads:
            self._leads = dict(_leads(tick.run))
        self._cells = tuple(".".join(key) for key in tick.signals.touch.cells)
        self._settings = tick.actuation.settings
        self._predicates.append("".join(run.predicate for _, run in runs))
        row = {
            "time": observation.time,
            "positions": observation.positions,
            "velocities": observation.velocities,
            "references": tick.actuation.reference.copy(),
            "potentials": [run.phi for _, run in runs],
            "errors": [run.error for _, run in runs],
            "loads": list(tick.signals.touch.loads.copy()),
            "flags": [_flags(run) for _, run in runs],
            "sight": [_sight(each) for each in tick.signals.vision.instances.values()],
            "guard_held": tick.actuation.load_guards.records["held"].tolist(),
            **{f"signal_{each.name}": _value(each, tick.signals) for each in self._resources},
        }
        self._channels = tick.signals.vision.channels
        self._guards = tick.actuation.load_guards.names
        self._apart.append(tick.actuation.clearance.holding)
        for each in self._distances:
            pairs, pair = self._pairs[each.name], tick.signals.distances.pair(each)
            row[f"pair_{each.name}"] = pairs.setdefault(pair, len(pairs))
        for key, value in row.items():
            self._rows[key].append(value)
        self._note_levels(tick)
        self._note_scene()
        if observation.images:
            self._image_time.append(observation.time)
        for camera, image in observation.images.items():
            small = cv2.resize(image, None, fx=_THUMBNAIL_SCALE, fy=_THUMBNAIL_SCALE)
            self._images.setdefault(f"image_{camera}", []).append(small)
        self._ticks += 1  # an interrupt may come at any earlier line

    def _note_levels(self, tick: Tick) -> None:
        explained = self._explanation.note(tick)
        names = list(self._controllers)
        rows: list[tuple[float, ...]] = [_ABSENT] * len(names)
        for priority, level in enumerate(explained.levels):
            rows[names.index(level.name)] = _numbers(priority, level, names)
        self._levels.append(rows)
        self._at_limits.append([joint in explained.at_limits for joint in self._joints])

    def _note_scene(self) -> None:
        if self._scenery is None:
            return
        scenery = self._scenery()
        poses = {}
        for name in scenery.names():
            if name not in self._bodies:
                self._bodies[name] = tuple(scenery.parts(name))
            pose = scenery.pose(name)
            poses[name] = [*pose.position.tolist(), *pose.quaternion()]
        self._poses.append(poses)

    def write(self, directory: Path, result: EpisodeResult) -> Path:
        """Write ``episode_<seed>.npz`` and ``.json`` below ``directory``; return the latter.

        Raises:
            OSError: If they cannot be written; the error names the file.
        """
        directory.mkdir(parents=True, exist_ok=True)
        arrays_file, summary_file = RecordingFolder(directory).files(result.seed)
        arrays = self._arrays()
        replace_file(
            arrays_file, lambda file: np.savez_compressed(file, allow_pickle=False, **arrays)
        )
        text = json.dumps(self._summary(result), indent=1, ensure_ascii=False)
        write_text(text, summary_file)
        return summary_file

    @property
    def _held_apart(self) -> list[str]:
        """Pairs of links that were held apart for longest."""
        counts = Counter(name for pairs in self._apart[: self._ticks] for name in pairs)
        return [name for name, _ in counts.most_common(_MOST_PAIRS)]

    def _arrays(self) -> dict[str, NDArray[Any]]:
        ticks = self._ticks
        # An interrupt within a tick leaves some lists longer than others. All are cut to the
        # complete ticks.
        arrays: dict[str, NDArray[Any]] = {
            key: np.array(rows[:ticks], dtype=float) for key, rows in self._rows.items()
        }
        if names := self._held_apart:
            held = np.array([[name in pairs for name in names] for pairs in self._apart[:ticks]])
            arrays["guard_held"] = np.hstack([arrays["guard_held"].reshape(ticks, -1), held])
        levels = np.array(self._levels[:ticks], dtype=float)
        levels = levels.reshape(ticks, len(self._controllers), len(_LEVEL))
        for index, (key, kind) in enumerate(_LEVEL.items()):
            arrays[key] = levels[:, :, index].astype(kind)
        arrays["at_limits"] = np.array(self._at_limits[:ticks], dtype=bool)
        # A body may appear or vanish during the episode; each body that was ever there has a
        # column.
        gone = [np.nan] * 7
        scene = [[poses.get(name, gone) for name in self._bodies] for poses in self._poses[:ticks]]
        arrays["scene"] = np.array(scene, dtype=float).reshape(len(scene), len(self._bodies), 7)
        images = min([len(self._image_time), *map(len, self._images.values())])
        arrays |= {key: np.array(rows[:images]) for key, rows in self._images.items()}
        arrays["image_time"] = np.array(self._image_time[:images])
        return arrays

    def _summary(self, result: EpisodeResult) -> dict[str, object]:
        return {
            "cbdsl": 1,
            "kind": "recording",
            "version": VERSION,
            "result": asdict(result),
            "source": self._source[:2],
            "shared": dict(self._source[2]),
            "joints": self._joints,
            "controllers": list(self._controllers),
            "load_cells": self._cells,
            "guards": [*self._guards, *self._held_apart],
            "predicates": self._predicates[: self._ticks],
            "transitions": [asdict(transition) for transition in self._transitions],
            "members": members(self._program),
            "limits": limits(self._program),
            "automata": dict(self._automata),
            "leads": self._leads,
            "channels": self._channels,
            "triples": {name: triple(each) for name, each in self._controllers.items()},
            "signals": {
                each.name: {
                    "type": str(each.type),
                    "place": is_place(each),
                    "channels": list(channels_of(each.source)),
                    **({"pairs": [*self._pairs[each.name]]} if each.name in self._pairs else {}),
                }
                for each in self._resources
            },
            "scene": {
                name: [drawn(part) for part in parts] for name, parts in self._bodies.items()
            },
            "robot": {
                "name": self._robot.name,
                "urdf": self._urdf.read_text("utf-8", errors="replace"),
                "folder": str(self._urdf.parent.resolve()),
                "singular_value": self._settings.singular_value,
                "lead": self._settings.lead if math.isfinite(self._settings.lead) else None,
                "couplings": {
                    name: coupling.recorded for name, coupling in self._robot.couplings.items()
                },
                "cameras": {
                    name: camera.model_dump(mode="json")
                    for name, camera in self._robot.cameras.items()
                },
                "tips": {
                    name: {
                        "joint": effector.joints[0],
                        "link": effector.tip.link,
                        "offset": list(effector.tip.offset),
                    }
                    for name, effector in self._robot.effectors.items()
                    if effector.tip is not None
                },
                "cells": {
                    f"{hand}.{finger}": cell.link
                    for hand, fingers in self._robot.load_cells.items()
                    for finger, cell in fingers.items()
                },
            },
        }


def _numbers(priority: int, level: LevelExplanation, names: list[str]) -> tuple[float, ...]:
    """Return the numbers of ``_LEVEL``; holder indices count the limits after all controllers."""
    holders = [*names, *HOLDERS]
    held_by = holders.index(level.held_by) if level.held_by else -1
    return (priority, level.share, level.rank, level.singular_value, level.predicted, held_by)


def members(program: CheckedProgram) -> dict[str, tuple[str, ...]]:
    """Return the members that the characters of the states stand for; see ``of_use``."""
    return by_use(program, lambda each: each.members)


def limits(program: CheckedProgram) -> dict[str, dict[str, object]]:
    """Return the limits of transitions and times, s; see ``of_use``."""
    keys = ("transitions", "transition_time", "idle_time", "episode_time", "lost_time")
    return by_use(program, lambda each: {key: getattr(each, key) for key in keys})


def _leads(run: ProgramRun, prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield the qualified names of the controllers that determine members, and the members."""
    for action in run.program.actions:
        # ``leads`` has the highest priority first, and primitives have the written order.
        parts = action.composition.primitives if action.composition else ()
        for part, lead in zip(parts, reversed(run.leads(action)), strict=True):
            yield prefix + lead.controller.name, part.name
    for name, child in run.children.items():
        yield from _leads(child, f"{prefix}{name}.")


def _flags(run: ControllerRun) -> int:
    """Return the facts of ``FLAGS`` as bits."""
    return sum(bool(getattr(run, name)) << bit for bit, name in enumerate(FLAGS))


def _sight(instances: Instances) -> int:
    """Return the index in ``SIGHT`` of a channel's attended object."""
    number, cameras = instances.attended, instances.sightings
    seen = [number in sightings for sightings in cameras]
    if not instances.memories:  # one camera gives no positions
        return SIGHT.index("seen" if any(seen) else "unseen")
    if instances.memories[number].position is None:
        seen = [bool(sightings) for sightings in cameras]
        is_whole = not any(each.region.clipped for one in cameras for each in one.values())
        both = "unmatched" if instances.regions == 1 and is_whole else "ambiguous"
        return SIGHT.index(both if all(seen) else "partly" if any(seen) else "unseen")
    if not any(seen):
        is_hidden = instances.memories[number].is_accounted_for
        return SIGHT.index("hidden" if is_hidden else "missing")
    return SIGHT.index("several" if min(len(instances.known), instances.regions) > 1 else "seen")


def triple(controller: Controller) -> dict[str, object]:
    """Return the typed triple of a controller for display, with the unit of its error."""
    reference = controller.reference
    base = reference.base if isinstance(reference, Relative) else reference
    if isinstance(reference, Literal):
        shown = ", ".join(f"{value:g}" for value in reference.values)
    elif isinstance(reference, AlongNormals):
        shown = f"{reference.force:g} N along normals"
    elif isinstance(reference, Relative):
        shown = str(reference)
    else:
        shown = "" if reference is None else reference.name
    return {
        "potential": controller.potential,
        "feedback": controller.feedback.name,
        "reference": shown,
        "base": base.name if isinstance(base, Resource) else "",
        "requires": controller.requires or "",
        "effector": controller.effector.name,
        "unit": controller.task.unit,
    }


def is_place(resource: Resource) -> bool:
    """Return whether a resource's value is a point in the world."""
    return str(resource.type) == "position" and isinstance(resource.source, _PLACES)


def _value(resource: Resource, signals: Signals) -> NDArray[np.float64]:
    """Return a resource's value in SI, or NaN in the same shape while it is undefined."""
    reading = signals.read(resource)
    if reading is not None:
        return reading.value
    return np.full(_SHAPES.get(resource.type.name, (resource.type.size,)), np.nan)


def drawn(part: Part) -> dict[str, object]:
    """Return a part as JSON data, with its mesh simplified for display on a page."""
    row = part._asdict()
    mesh = row.pop("mesh")
    if mesh is not None:
        small = simplified(mesh)
        corners = small.corners.round(5).tolist()
        row["mesh"] = {"corners": corners, "triangles": small.triangles.tolist()}
    return row
