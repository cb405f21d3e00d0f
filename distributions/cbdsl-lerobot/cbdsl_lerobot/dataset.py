"""Datasets of LeRobot, format v3.0: Parquet files of frames, and metadata as JSON and Parquet.

Images are PNG files inside of the Parquet files, or videos beside them. Columns beyond the format
are the program's state and action of each frame, and the seed, context, ending and reward of each
episode.

Needs the extra ``lerobot``.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from cbdsl.extend.export import Recorded, UsageError
from cbdsl_lerobot.dataset_frames import Frames, frame_rate, frames_of
from cbdsl_lerobot.statistics import Statistics
from cbdsl_lerobot.video import video_info, write_video

Json = dict[str, Any]

_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_DATA, _EPISODES = f"data/{_FILE}", f"meta/episodes/{_FILE}"
_VIDEO = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
_FILES_PER_CHUNK, _LARGEST_FILE = 1000, 100
_MEGABYTE = 1024 * 1024
_INDICES = ("frame_index", "episode_index", "index", "task_index")
_IMAGE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
_TYPES = {"float32": pa.float32(), "bool": pa.bool_(), "int64": pa.int64(), "string": pa.string()}


def write_dataset(
    recordings: Iterable[Recorded],
    target: Path,
    *,
    rate: int | None = None,
    task: str | None = None,
    signals: Sequence[str] = (),
    videos: bool = False,
    overwrite: bool = False,
) -> tuple[int, int]:
    """Write recordings as one dataset and return the numbers of episodes and frames.

    Args:
        recordings: Recordings of one robot.
        target: Folder of the dataset, which appears when it is complete.
        rate: Frames per second; that of the first recording's images without it.
        task: Sentence that names the task; the name of each program without it.
        signals: Recorded signals that become ``observation.environment_state``, one after another.
        videos: True if images become MP4 videos, which are smaller and not exact.
        overwrite: True if a dataset that is there may be replaced.

    Raises:
        UsageError: The folder is there, a recording lacks a signal or differs from the first one in
            joints, cameras or load cells, the rate is above that of control, or the images fit no
            video.
        OSError: The folder cannot be written.
    """
    _require_free(target, overwrite=overwrite)
    target.parent.mkdir(parents=True, exist_ok=True)
    # An interrupted export leaves no folder that looks complete. The process number separates
    # simultaneous exports.
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        with _Dataset(partial, rate, signals, videos=videos) as dataset:
            for recorded in recordings:
                dataset.add(recorded, task)
        if target.exists():
            # A folder with files cannot be replaced by a renamed one.
            shutil.rmtree(target)
        os.replace(partial, target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return dataset.episodes, dataset.frames


def _require_free(target: Path, *, overwrite: bool) -> None:
    # The libraries that write and read datasets know paths as Unicode text only.
    if any("\ud800" <= sign <= "\udfff" for sign in str(target)):
        raise UsageError(
            f"{target}: the name is not UTF-8, as those of datasets are; choose another folder "
            "with --out"
        )
    if not target.exists():
        return
    if not overwrite:
        raise UsageError(
            f"{target}: already exists; choose another folder with --out, or replace the dataset "
            "with --overwrite"
        )
    # A mistyped `--out` must not delete a folder of other data.
    if not (target / "meta" / "info.json").is_file():
        raise UsageError(f"{target}: not a LeRobot dataset, and not replaced; choose another --out")


class _Dataset:
    """A dataset that episodes are added to.

    Attributes:
        episodes, frames: Numbers of both so far.
    """

    def __init__(
        self, folder: Path, rate: int | None, signals: Sequence[str], *, videos: bool
    ) -> None:
        self._folder, self._rate, self._videos = folder, rate, videos
        self._signals = signals
        self._features: Json = {}
        self._first: Recorded | None = None
        self._tasks: dict[str, int] = {}
        self._rows: list[Json] = []
        self._statistics = Statistics()
        self._writer: pq.ParquetWriter | None = None
        self._file = -1
        self.episodes = self.frames = 0

    def __enter__(self) -> _Dataset:
        self._folder.mkdir()  # an existing one is another's
        (self._folder / "meta").mkdir()
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        if self._writer is not None:
            self._writer.close()
        if kind is None:
            self._write_metadata()

    def add(self, recorded: Recorded, task: str | None) -> None:
        """Add an episode as a row group of its own."""
        self._rate = self._rate or frame_rate(recorded)
        frames = frames_of(recorded, self._rate, task, self._signals)
        # All row groups of a file share one schema, so that this check precedes any writing.
        self._require_like_first(recorded, _features(frames, self._rate if self._videos else None))
        task_index = self._tasks.setdefault(frames.task, len(self._tasks))
        columns = self._columns(len(frames), task_index)
        table = _table(frames, columns, self._features)
        self._writer_of(table.schema).write_table(table, row_group_size=max(len(frames), 1))
        self._statistics.add(frames, columns)
        own = Statistics()
        own.add(frames, columns)
        row = self._row(recorded, frames, own.table())
        self._rows.append(row | (self._filmed(frames, self._rate) if self._videos else {}))
        self.episodes += 1
        self.frames += len(frames)

    def _filmed(self, frames: Frames, rate: int) -> Json:
        """Write a video of each camera and return the columns of their places."""
        # Each episode is a video of its own, with times from 0.
        chunk, file = divmod(self.episodes, _FILES_PER_CHUNK)
        place, columns = {"chunk_index": chunk, "file_index": file}, Json()
        for name, images in frames.images.items():
            write_video(self._folder / _VIDEO.format(video_key=name, **place), images, rate)
            span = {"from_timestamp": 0.0, "to_timestamp": len(images) / rate}
            columns |= {f"videos/{name}/{key}": value for key, value in {**place, **span}.items()}
        return columns

    def _require_like_first(self, recorded: Recorded, features: Json) -> None:
        first = self._first
        if first is None:
            self._first, self._features = recorded, features
            return
        robot, other = recorded.summary["robot"]["name"], first.summary["robot"]["name"]
        differing = [
            name
            for name in {**self._features, **features}
            if self._features.get(name) != features.get(name)
        ]
        if robot != other:
            differing = [f"robot '{robot}' instead of '{other}'"]
        if differing:
            raise UsageError(
                f"{recorded.file}: differs from {first.file} in {', '.join(differing)}; a dataset "
                "has one robot with the same sensors, so export them by themselves"
            )

    def _columns(self, count: int, task_index: int) -> dict[str, NDArray[Any]]:
        """Return the numbers and times of the frames as columns."""
        frame = np.arange(count)
        return {
            "timestamp": (frame / (self._rate or 1)).astype(np.float32),
            "frame_index": frame,
            "episode_index": np.full(count, self.episodes),
            "index": self.frames + frame,
            "task_index": np.full(count, task_index),
        }

    def _writer_of(self, schema: pa.Schema) -> pq.ParquetWriter:
        """Return the writer of the file that takes the next episode."""
        writer = self._writer
        if writer is not None:
            path = self._folder / _DATA.format(**self._place())
            # Files may exceed the limit by one episode, because no episode is divided.
            if path.stat().st_size < _LARGEST_FILE * _MEGABYTE:
                return writer
            writer.close()
        self._file += 1
        path = self._folder / _DATA.format(**self._place())
        path.parent.mkdir(parents=True, exist_ok=True)
        self._writer = pq.ParquetWriter(path, schema)
        return self._writer

    def _place(self) -> dict[str, int]:
        chunk, file = divmod(self._file, _FILES_PER_CHUNK)
        return {"chunk_index": chunk, "file_index": file}

    def _row(self, recorded: Recorded, frames: Frames, statistics: Mapping[str, Json]) -> Json:
        """Return the metadata of an episode."""
        result = recorded.summary["result"]
        row: Json = {
            "episode_index": self.episodes,
            "tasks": [frames.task],
            "length": len(frames),
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + len(frames),
            **{f"data/{key}": value for key, value in self._place().items()},
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        kept = ("program", "stage", "context", "seed", "rewarded", "succeeded", "ending")
        row |= {f"recording/{key}": result[key] for key in kept}
        for name, numbers in statistics.items():
            row |= {f"stats/{name}/{key}": value for key, value in numbers.items()}
        return row

    def _write_metadata(self) -> None:
        meta = self._folder / "meta"
        episodes = self._folder / _EPISODES.format(chunk_index=0, file_index=0)
        episodes.parent.mkdir(parents=True)
        pq.write_table(pa.Table.from_pylist(self._rows), episodes)
        pq.write_table(_task_table(self._tasks), meta / "tasks.parquet")
        _write_json(meta / "stats.json", self._statistics.table())
        _write_json(meta / "info.json", self._info())

    def _info(self) -> Json:
        robot = self._first.summary["robot"]["name"] if self._first is not None else None
        return {
            "codebase_version": "v3.0",
            "robot_type": robot,
            "total_episodes": self.episodes,
            "total_frames": self.frames,
            "total_tasks": len(self._tasks),
            "chunks_size": _FILES_PER_CHUNK,
            "data_files_size_in_mb": _LARGEST_FILE,
            "video_files_size_in_mb": 200,
            "fps": self._rate,
            "splits": {"train": f"0:{self.episodes}"},
            "data_path": _DATA,
            "video_path": _VIDEO if self._videos else None,
            "features": self._features,
        }


def _features(frames: Frames, video_rate: int | None) -> Json:
    """Return the description of all columns, and of videos at a rate in Hz."""
    features: Json = {}
    for name, values in frames.numbers.items():
        names = list(frames.names[name]) if name in frames.names else None
        features[name] = _feature(str(values.dtype), [len(names) if names else 1], names)
    for name, images in frames.images.items():
        axes = ["height", "width", "channels"]
        features[name] = _feature("image", list(images.shape[1:]), axes)
        if video_rate is not None:
            info = video_info(images.shape[1], images.shape[2], video_rate)
            features[name] |= {"dtype": "video", "info": info}
    features |= {name: _feature("string", [1], None) for name in frames.texts}
    features["timestamp"] = _feature("float32", [1], None)
    return features | {name: _feature("int64", [1], None) for name in _INDICES}


def _feature(dtype: str, shape: list[int], names: list[str] | None) -> Json:
    return {"dtype": dtype, "shape": shape, "names": names}


def _table(frames: Frames, columns: Mapping[str, NDArray[Any]], features: Json) -> pa.Table:
    """Return the frames as a table, in the order of the features."""
    values: dict[str, Any] = {**frames.numbers, **frames.texts, **columns}
    arrays = []
    # Videos are files of their own.
    features = {name: each for name, each in features.items() if each["dtype"] != "video"}
    for name, feature in features.items():
        if feature["dtype"] == "image":
            arrays.append(pa.array(map(_png, frames.images[name]), _IMAGE))
        elif feature["names"] is not None:
            size = feature["shape"][0]
            flat = pa.array(values[name].ravel(), _TYPES[feature["dtype"]])
            arrays.append(pa.FixedSizeListArray.from_arrays(flat, size))
        else:
            arrays.append(pa.array(values[name], _TYPES[feature["dtype"]]))
    return pa.table(arrays, names=list(features))


def _png(image: NDArray[np.uint8]) -> dict[str, bytes | None]:
    _, data = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
    return {"bytes": data.tobytes(), "path": None}


def _task_table(tasks: Mapping[str, int]) -> pa.Table:
    """Return the numbers of the tasks, with their sentences as the index that pandas reads."""
    table = pa.table({"task_index": list(tasks.values()), "task": list(tasks)})
    columns = [
        {
            "name": name,
            "field_name": name,
            "pandas_type": kind,
            "numpy_type": numpy,
            "metadata": None,
        }
        for name, kind, numpy in (("task_index", "int64", "int64"), ("task", "unicode", "object"))
    ]
    description = {"index_columns": ["task"], "column_indexes": [], "columns": columns}
    return table.replace_schema_metadata({"pandas": json.dumps(description)})


def _write_json(path: Path, content: Json) -> None:
    path.write_text(json.dumps(content, indent=4, ensure_ascii=False) + "\n", encoding="utf-8")
