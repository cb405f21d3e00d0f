"""Recordings read from files, with clear messages for invalid ones."""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from cbdsl.diagnostics.errors import UsageError
from cbdsl.diagnostics.reason import reason
from cbdsl.program.transition import Transition
from cbdsl.program.uses import of_use
from cbdsl.reporting.automaton_text import transition_text
from cbdsl.reporting.recorded_form import array_faults, summary_faults
from cbdsl.runtime.recording import VERSION
from cbdsl.storage.contents import contents, json_of

_NEEDED = (
    "time", "positions", "references", "potentials", "loads", "level_priority", "level_share",
    "level_rank", "level_singular_value", "level_predicted", "level_held_by", "at_limits", "scene",
    "image_time",
)  # fmt: skip

_OPTIONAL = ("velocities", "errors", "guard_held", "flags", "sight")

_TOLD = (
    "result", "joints", "controllers", "load_cells", "predicates", "transitions", "members",
    "triples", "signals", "scene", "robot",
)  # fmt: skip

# Includes archives with damaged sizes, compression or encryption.
_UNREADABLE = (
    OSError, ValueError, EOFError, RuntimeError, MemoryError, OverflowError, zipfile.BadZipFile,
    zlib.error,
)  # fmt: skip

# Enough for an hour of states, or for five minutes with the images of two cameras.
_MOST_SUMMARY_BYTES = 50_000_000
_MOST_ARRAY_BYTES = 1_000_000_000

_MAKING = "cb run PROGRAM --record FOLDER writes one when an episode ends"


@dataclass(frozen=True)
class Recorded:
    """Recorded episode.

    Attributes:
        file: JSON file of the recording.
        summary: Content of the JSON file.
        arrays: Arrays of the NPZ file, by name.
    """

    file: Path
    summary: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]]

    @property
    def controllers(self) -> list[str]:
        """Names of the columns of values per controller."""
        return list(self.summary["controllers"])

    @property
    def failed(self) -> bool:
        """True if the episode did not succeed."""
        result = self.summary["result"]
        is_rewarded = result["rewarded"] or result.get("outcome") == "success"
        return not result.get("succeeded", is_rewarded)  # older recordings lack it

    @cached_property
    def transitions(self) -> list[dict[str, Any]]:
        """Transitions with their ``words``, such as ``lift -> carry, since lift is at rest``.

        The words are empty for an action that is no step, and in old recordings.
        """
        rows, automata = [], self.summary.get("automata", {})
        for each in self.summary["transitions"]:
            automaton = of_use(automata, each["program"], each.get("use", ""))
            words = "" if automaton is None else transition_text(automaton, Transition(**each))
            rows.append({**each, "words": words})
        return rows

    def program_change(self) -> str:
        """Return a clause if the recorded program has changed since, or is missing; else empty."""
        from cbdsl.checking.knowledge.staleness import program_change
        from cbdsl.yaml_text.library import Library

        file, sha256 = self.summary.get("source", ("", ""))
        if not file:
            return ""
        robot, shared = self.summary["robot"]["name"], self.summary.get("shared", {})
        change = program_change(Path(file), robot, sha256, shared, Library())
        return f"{change}; names are those of the recording" if change else ""

    def members(self, transition: Mapping[str, Any]) -> Sequence[str]:
        """Return the members that the characters of a transition's states stand for."""
        use = transition.get("use", "")
        return of_use(self.summary["members"], transition["program"], use) or ()

    @property
    def signals(self) -> Mapping[str, NDArray[Any]]:
        """Values by name of the resource, NaN while undefined, shape (T, ...)."""
        return {name: self.arrays[f"signal_{name}"] for name in self.summary["signals"]}

    @property
    def images(self) -> Mapping[str, NDArray[Any]]:
        """RGB images by camera, shape (images, height, width, 3), at ``image_time``."""
        return {
            key.removeprefix("image_"): array
            for key, array in self.arrays.items()
            if key.startswith("image_") and key != "image_time"
        }


def find_recordings(path: Path) -> list[Path]:
    """Return the JSON files of a recording, or of all recordings in a folder, by seed.

    Args:
        path: Folder, or either file of a recording.

    Raises:
        UsageError: There is none.
    """
    if not path.exists():
        raise UsageError(f"{path}: there is no such file or folder")
    if not path.is_dir():
        return [path.with_suffix(".json") if path.suffix == ".npz" else path]
    files = {each.with_suffix(".json") for each in path.glob("episode_*.json")}
    files |= {each.with_suffix(".json") for each in path.glob("episode_*.npz")}
    if not files:
        raise UsageError(
            f"{path}: no recording is in this folder; {_MAKING}, and none for a run that was killed"
        )
    # Shorter names first: `episode_9` precedes `episode_10`.
    return sorted(files, key=lambda each: (len(each.name), each.name))


def read_recording(file: Path) -> Recorded:
    """Read a recording by its JSON file; the arrays are beside it.

    Raises:
        UsageError: The file is no recording, an old one, or an incomplete one.
    """
    summary = _summary(file)
    absent = [key for key in _TOLD if key not in summary]
    if absent:
        raise UsageError(f"{file}: lacks {', '.join(absent)}")
    _require_sound(file, summary_faults(summary))
    signals = [f"signal_{name}" for name in summary["signals"]]
    images = [f"image_{name}" for name in summary["robot"].get("cameras", {})]
    pairs = [f"pair_{name}" for name, each in summary["signals"].items() if each.get("pairs")]
    names = {*_NEEDED, *_OPTIONAL, *signals, *pairs, *images}
    arrays = _arrays(file.with_suffix(".npz"), names)
    missing = [key for key in (*_NEEDED, *signals) if key not in arrays]
    if missing:
        raise UsageError(f"{file.with_suffix('.npz')}: lacks {', '.join(missing)}")
    # All arrays but images have a row for each tick. Without ground truth, the scene is empty.
    ticks = {len(summary["predicates"])}
    ticks |= {len(array) for key, array in arrays.items() if not key.startswith("image_")}
    ticks -= {0} if not len(arrays["scene"]) else set()
    if len(ticks) != 1:
        raise UsageError(f"{file}: the two files of this recording are not of the same episode")
    _require_sound(file.with_suffix(".npz"), array_faults(summary, arrays))
    return Recorded(file, summary, arrays)


def _require_sound(file: Path, faults: Iterator[str]) -> None:
    fault = next(faults, None)
    if fault is not None:
        raise UsageError(f"{file}: damaged ({fault}); record the episode again")


def _summary(file: Path) -> Mapping[str, Any]:
    if not file.exists():
        raise UsageError(
            f"{file}: missing; this recording was cut short, or only its .npz file was copied"
        )
    if file.suffix != ".json":
        raise UsageError(f"{file}: no recording, which is a .json and a .npz file; {_MAKING}")
    try:
        summary = json_of(contents(file, _MOST_SUMMARY_BYTES))
    except OSError as error:
        raise UsageError(f"{file}: {reason(error)}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file}: no recording, or one cut short; {_MAKING}") from error
    if isinstance(summary, dict) and summary.get("kind") == "recording":
        if summary.get("version") == VERSION:
            return summary
        raise UsageError(
            f"{file}: a recording of version {summary.get('version')}, but this cb reads "
            f"version {VERSION}; record the episode again"
        )
    if isinstance(summary, dict) and {"result", "predicates"} <= summary.keys():
        raise UsageError(
            f"{file}: recorded by an older cb, without what a replay needs; record it again"
        )
    raise UsageError(f"{file}: no recording; {_MAKING}")


def _arrays(file: Path, names: Set[str]) -> Mapping[str, NDArray[Any]]:
    if not file.exists():
        raise UsageError(f"{file}: missing; a recording is two files, .json and .npz")
    try:
        _require_bounded(file, names)
        with np.load(file, allow_pickle=False) as loaded:
            return {key: loaded[key] for key in names if key in loaded}
    except _UNREADABLE as error:
        raise UsageError(f"{file}: damaged, or cut short; record the episode again") from error


def _require_bounded(file: Path, names: Set[str]) -> None:
    """Check the sizes that an archive declares, before any of it is unpacked.

    Raises:
        UsageError: They are larger than those of any recording.
        ValueError: An array is declared to be larger than its part of the archive.
    """
    if not file.is_file():
        raise UsageError(f"{file}: not a regular file")
    # A small archive can unpack to terabytes, and a forged header can make `np.load` allocate them.
    with zipfile.ZipFile(file) as archive:
        # Each name is read once, also in an archive of many equal or unknown names.
        present = {f"{name}.npy" for name in names} & archive.NameToInfo.keys()
        parts = [archive.getinfo(name) for name in present]
        if sum(part.file_size for part in parts) > _MOST_ARRAY_BYTES:
            raise UsageError(
                f"{file}: its arrays have more than {_MOST_ARRAY_BYTES} bytes; record a shorter "
                "episode"
            )
        for part in parts:
            with archive.open(part) as stream:
                _require_array(stream, part.file_size)


def _require_array(stream: IO[bytes], size: int) -> None:
    """Check that an array is no larger than its part of the archive.

    Raises:
        ValueError: It is, or it is no array.
    """
    version = np.lib.format.read_magic(stream)
    readers = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    if version not in readers:
        raise ValueError(f"format {version} is unknown")
    shape, _, kind = readers[version](stream)
    if kind.itemsize * math.prod(shape) > size:
        raise ValueError("it is larger than its part of the archive")
