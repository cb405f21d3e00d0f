"""Recordings: what a run sensed, wanted and concluded, kept for later viewing."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from cbdsl.program.transition import Transition
from cbdsl.robot.signals import Signals
from cbdsl.runtime.controller_run import ControllerRun
from cbdsl.runtime.episode import EpisodeResult, Tick
from cbdsl.runtime.program_run import ProgramRun
from cbdsl.types.resource import Origin, Resource

# Half of the images' width is enough to see what happened.
_THUMBNAIL_SCALE = 0.5

# An orientation is a rotation matrix and a pose a homogeneous transform; the rest are vectors.
_SHAPES = {"orientation": (3, 3), "pose": (4, 4)}


def require_writable(directory: Path) -> None:
    """Make sure that recordings can be kept in a folder.

    Raises:
        OSError: it cannot be made or written.
    """
    directory.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=directory):
        pass


class Recording:
    """Keeps one episode and writes it to two files: numbers as NPZ, the rest as JSON.

    The NPZ holds, per control tick: ``time`` s, ``positions`` and ``references`` of the actuated
    joints in rad (T, n), ``potentials`` (T, c) and ``errors`` (T, c) with NaN where undefined,
    ``loads`` in N and N m (T, cells, 6), and as ``signal_<resource>`` the value of each resource
    in SI (T, ...), NaN while undefined; per image: ``image_time`` and ``image_<camera>``.

    Args:
        joints: names of the actuated joints.
        resources: what the program can read; what it draws from internal models is no signal.
    """

    def __init__(self, joints: tuple[str, ...], resources: Iterable[Resource]) -> None:
        self._joints = joints
        self._resources = [each for each in resources if each.origin is not Origin.MODEL]
        self._rows: dict[str, list[Any]] = {
            key: [] for key in ("time", "positions", "references", "potentials", "errors", "loads")
        }
        self._rows |= {f"signal_{each.name}": [] for each in self._resources}
        self._images: dict[str, list[Any]] = {}
        self._image_time: list[float] = []
        self._predicates: list[str] = []
        self._transitions: list[Transition] = []
        self._controllers: tuple[str, ...] = ()
        self._cells: tuple[str, ...] = ()

    def note_transition(self, transition: Transition) -> None:
        """Keep a transition."""
        self._transitions.append(transition)

    def note_tick(self, tick: Tick) -> None:
        """Keep a control tick."""
        runs = list(_all_runs(tick.run))
        observation = tick.observation
        self._controllers = tuple(name for name, _ in runs)
        self._cells = tuple(".".join(key) for key in observation.loads)
        self._predicates.append("".join(run.predicate for _, run in runs))
        row = {
            "time": observation.time,
            "positions": observation.positions,
            "references": tick.actuation.reference.copy(),
            "potentials": [run.phi for _, run in runs],
            "errors": [run.error for _, run in runs],
            "loads": list(observation.loads.values()),
        }
        row |= {f"signal_{each.name}": _value(each, tick.signals) for each in self._resources}
        for key, value in row.items():
            self._rows[key].append(value)
        if observation.images:
            self._image_time.append(observation.time)
        for camera, image in observation.images.items():
            small = cv2.resize(image, None, fx=_THUMBNAIL_SCALE, fy=_THUMBNAIL_SCALE)
            self._images.setdefault(f"image_{camera}", []).append(small)

    def write(self, directory: Path, result: EpisodeResult) -> Path:
        """Write ``episode_<seed>.npz`` and ``.json`` below ``directory``; returns the latter.

        Raises:
            OSError: the directory cannot be written.
        """
        directory.mkdir(parents=True, exist_ok=True)
        arrays = {key: np.array(rows, dtype=float) for key, rows in self._rows.items()}
        arrays |= {key: np.array(images) for key, images in self._images.items()}
        arrays["image_time"] = np.array(self._image_time)
        stem = directory / f"episode_{result.seed}"
        _write_arrays(stem.with_suffix(".npz"), arrays)
        summary = {
            "result": asdict(result),
            "joints": self._joints,
            "controllers": self._controllers,
            "load_cells": self._cells,
            "predicates": self._predicates,
            "transitions": [asdict(transition) for transition in self._transitions],
        }
        text = json.dumps(summary, indent=1, ensure_ascii=False)
        _replace(stem.with_suffix(".json"), text.encode())
        return stem.with_suffix(".json")


def _all_runs(run: ProgramRun, prefix: str = "") -> list[tuple[str, ControllerRun]]:
    """All controllers of a program and of the programs it uses, with qualified names."""
    found = [(prefix + item.controller.name, item) for item in run.runs]
    for name, child in run.children.items():
        found += _all_runs(child, f"{prefix}{name}.")
    return found


def _value(resource: Resource, signals: Signals) -> NDArray[np.float64]:
    """A resource's value in SI, or NaN in the same shape while it is undefined."""
    reading = signals.read(resource)
    if reading is not None:
        return reading.value
    return np.full(_SHAPES.get(resource.type.name, (resource.type.size,)), np.nan)


def _write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    with tempfile.TemporaryFile() as buffer:
        np.savez_compressed(buffer, allow_pickle=False, **arrays)
        buffer.seek(0)
        _replace(path, buffer.read())


def _replace(path: Path, content: bytes) -> None:
    """Write a file so that nobody ever sees half of it."""
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        partial.write_bytes(content)
        os.replace(partial, path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
