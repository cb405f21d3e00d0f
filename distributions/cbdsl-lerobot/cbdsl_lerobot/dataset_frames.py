"""Recorded episodes as frames at a constant rate, as LeRobot's datasets have them.

A frame holds the newest observation at its time. Its action is the last reference before the next
frame. At a rate below that of control, joints reach it with the next frame, but the reference of
the frame's own tick earlier.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.extend.export import Recorded, UsageError

Array = NDArray[Any]

# Times of ticks and frames that differ by less are equal, s.
_ROUNDING = 1e-6
_AXES = tuple(f"{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz")


@dataclass(frozen=True)
class Frames:
    """Frames of one episode.

    Attributes:
        numbers: Numbers by feature, shape (frames, components).
        names: Names of the components, by feature.
        texts: Texts by feature, one per frame.
        images: RGB images by feature, shape (frames, height, width, 3).
        task: Sentence that names the task.
    """

    numbers: Mapping[str, Array]
    names: Mapping[str, Sequence[str]]
    texts: Mapping[str, Sequence[str]]
    images: Mapping[str, Array]
    task: str

    def __len__(self) -> int:
        return len(self.numbers["action"])


def frame_rate(recorded: Recorded) -> int:
    """Return the rate of the images, or of control if there are none, in whole Hz, at least 1."""
    images = recorded.arrays["image_time"]
    # Datasets state whole rates; slower images count as one a second.
    return max(1, round(_rate(images if len(images) > 1 else recorded.arrays["time"])))


def _rate(times: Array) -> float:
    """Return the rate of most of the times, Hz; 1 for a single one."""
    return float(1 / np.median(np.diff(times))) if len(times) > 1 else 1.0


def frames_of(
    recorded: Recorded, rate: int, task: str | None, signals: Sequence[str] = ()
) -> Frames:
    """Return the frames of an episode.

    Args:
        recorded: Episode.
        rate: Frames per second.
        task: Sentence that names the task; the name of the program without one.
        signals: Recorded signals of the frames, by name.

    Raises:
        UsageError: The rate is above that of control, or the recording lacks a signal.
    """
    arrays, summary = recorded.arrays, recorded.summary
    control = _rate(arrays["time"])
    if len(arrays["time"]) > 1 and rate > round(control):
        raise UsageError(
            f"--fps {rate}: {recorded.file} has {control:.0f} ticks per second; choose at most that"
        )
    # Sums of tick durations may end just below the time of a frame, which counts nevertheless.
    count = int((arrays["time"][-1] + _ROUNDING) * rate) + 1
    times = np.arange(count) / rate
    ticks = _newest(arrays["time"], times)
    # The last tick before the next frame; that of the last frame is the last one of all.
    last = np.searchsorted(arrays["time"], times[1:] - _ROUNDING, side="left") - 1
    last = np.append(last, len(arrays["time"]) - 1)
    joints = [f"{joint}.pos" for joint in summary["joints"]]
    numbers = {
        "observation.state": arrays["positions"][ticks].astype(np.float32),
        "action": arrays["references"][last].astype(np.float32),
    }
    names: dict[str, Sequence[str]] = {"observation.state": joints, "action": joints}
    if "velocities" in arrays:
        numbers["observation.velocity"] = arrays["velocities"][ticks].astype(np.float32)
        names["observation.velocity"] = [f"{joint}.vel" for joint in summary["joints"]]
    if summary["load_cells"]:
        loads = arrays["loads"][ticks].reshape(count, -1)
        numbers["observation.loads"] = loads.astype(np.float32)
        names["observation.loads"] = [
            f"{c}.{axis}" for c in summary["load_cells"] for axis in _AXES
        ]
    if signals:
        key = "observation.environment_state"
        numbers[key], names[key] = _signals(recorded, signals, ticks)
    shown = _newest(arrays["image_time"], times)
    images = {f"observation.images.{n}": each[shown] for n, each in recorded.images.items()}
    numbers |= _outcome(summary, times)
    return Frames(numbers, names, _program(summary, times), images, task or _task(summary))


def _signals(
    recorded: Recorded, signals: Sequence[str], ticks: NDArray[np.intp]
) -> tuple[Array, list[str]]:
    """Return recorded signals side by side, and the names of their components.

    Raises:
        UsageError: The recording has no such signal.
    """
    known = sorted(k.removeprefix("signal_") for k in recorded.arrays if k.startswith("signal_"))
    for name in signals:
        if name not in known:
            raise UsageError(
                f"--signals {name}: {recorded.file} has no such signal; it has {', '.join(known)}"
            )
    columns = [recorded.arrays[f"signal_{name}"][ticks].reshape(len(ticks), -1) for name in signals]
    names = [
        f"{name}.{place}"
        for name, column in zip(signals, columns, strict=True)
        for place in range(column.shape[1])
    ]
    return np.hstack(columns).astype(np.float32), names


def _newest(times: Array, moments: Array) -> NDArray[np.intp]:
    """Return the index of the last time that is not after each moment, 0 if all are."""
    index = np.searchsorted(times, moments + _ROUNDING, side="right") - 1
    return np.maximum(index, 0)


def _task(summary: Mapping[str, Any]) -> str:
    return str(summary["result"]["program"]).replace("_", " ")


def _passed(summary: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the transitions of the program itself, without those of programs that it uses."""
    return [row for row in summary["transitions"] if row["depth"] == 0]


def _outcome(summary: Mapping[str, Any], times: Array) -> dict[str, Array]:
    """Return the reward until the next frame, and the end and its success at the last frame."""
    reward, last = np.zeros(len(times), dtype=np.float32), np.arange(len(times)) == len(times) - 1
    for row in _passed(summary):
        # A transition at the time of a frame has been earned since the frame before.
        index = int(np.searchsorted(times + _ROUNDING, row["time"], side="left")) - 1
        reward[max(index, 0)] += row["reward"]
    result = summary["result"]
    success = last & bool(result["rewarded"] or result["succeeded"])
    return {"next.reward": reward, "next.done": last, "next.success": success}


def _program(summary: Mapping[str, Any], times: Array) -> dict[str, list[str]]:
    """Return the state of the program at each frame, and the action that it runs there."""
    passed = _passed(summary)
    members = summary["members"][summary["result"]["program"]]
    # Before the first transition, no member is active. After the last one, no action runs.
    states = ["X" * len(members), *(row["next_state"] for row in passed)]
    actions = [*(row["action"] for row in passed), ""]
    ends = np.array([row["time"] for row in passed])
    index = np.searchsorted(ends, times + _ROUNDING, side="right")
    return {
        "program.state": [states[k] for k in index],
        "program.action": [actions[k] for k in index],
    }
