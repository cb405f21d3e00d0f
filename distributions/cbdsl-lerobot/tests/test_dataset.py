"""Datasets of LeRobot, read back with pyarrow by the description in their ``info.json``."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from cbdsl.diagnostics.errors import UsageError
from cbdsl.reporting.recorded import Recorded
from tests.cli.test_main import cb

pytest.importorskip("av")
pytest.importorskip("pyarrow")
import pyarrow as pa
import pyarrow.parquet as pq

from cbdsl_lerobot.dataset import write_dataset

Row = dict[str, Any]
RATE = 15
TYPES = {"float32": pa.float32(), "int64": pa.int64(), "bool": pa.bool_(), "string": pa.string()}


@pytest.fixture(scope="module")
def folder(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a dataset of two episodes, the second one shorter."""
    target = tmp_path_factory.mktemp("kept") / "dataset"
    half = shortened(recorded, len(recorded.arrays["time"]) // 2)
    write_dataset([recorded, half], target, rate=RATE)
    return target


def shortened(recorded: Recorded, ticks: int) -> Recorded:
    """Return the first ticks of an episode, without reward."""
    end = recorded.arrays["time"][ticks - 1]
    shown = recorded.arrays["image_time"] <= end
    arrays = {
        key: array[shown] if key.startswith("image_") else array[:ticks]
        for key, array in recorded.arrays.items()
    }
    summary = json.loads(json.dumps(recorded.summary))
    summary["transitions"] = [row for row in summary["transitions"] if row["time"] <= end]
    summary["predicates"] = summary["predicates"][:ticks]
    ended = {"rewarded": False, "succeeded": False, "seed": 99, "program": "reachtouch"}
    summary["result"] |= ended
    return replace(recorded, summary=summary, arrays=arrays)


def info_of(folder: Path) -> Row:
    info: Row = json.loads((folder / "meta" / "info.json").read_text())
    return info


def table_of(folder: Path) -> pa.Table:
    """Return all frames, read from the file that ``data_path`` names."""
    path = info_of(folder)["data_path"].format(chunk_index=0, file_index=0)
    return pq.read_table(folder / path)


def episodes_of(folder: Path) -> list[Row]:
    rows: list[Row] = pq.read_table(folder / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    return rows


def rows_of(folder: Path, episode: int = 0) -> list[Row]:
    rows: list[Row] = table_of(folder).to_pylist()
    return [row for row in rows if row["episode_index"] == episode]


def test_every_column_is_of_its_described_type_and_shape(folder: Path) -> None:
    table, features = table_of(folder), info_of(folder)["features"]
    assert table.column_names == list(features)
    for name, feature in features.items():
        kind, shape = table.schema.field(name).type, feature["shape"]
        if feature["dtype"] == "image":
            assert {field.name for field in kind} == {"bytes", "path"}
        elif shape == [1]:
            assert kind == TYPES[feature["dtype"]], name
        else:
            assert pa.types.is_fixed_size_list(kind) and [kind.list_size] == shape, name
            assert kind.value_type == TYPES[feature["dtype"]]
            assert len(feature["names"]) == shape[0]


def test_counts_and_indices_agree(folder: Path) -> None:
    info, episodes, table = info_of(folder), episodes_of(folder), table_of(folder)
    assert (info["codebase_version"], info["fps"]) == ("v3.0", RATE)
    assert info["total_frames"] == table.num_rows == episodes[-1]["dataset_to_index"]
    assert info["total_episodes"] == len(episodes) == 2
    assert info["splits"] == {"train": "0:2"}
    assert table["index"].to_pylist() == list(range(table.num_rows))
    path = info["data_path"].format(chunk_index=0, file_index=0)
    groups = pq.ParquetFile(folder / path).metadata
    for number, episode in enumerate(episodes):
        rows = table.slice(episode["dataset_from_index"], episode["length"]).to_pylist()
        assert {row["episode_index"] for row in rows} == {number}
        assert [row["frame_index"] for row in rows] == list(range(len(rows)))
        times = np.array([row["timestamp"] for row in rows])
        assert times == pytest.approx(np.arange(len(rows)) / RATE, abs=1e-5)
        assert groups.row_group(number).num_rows == episode["length"]


@pytest.mark.parametrize("rate", [1, 7, 15, 30, 60])
def test_frames_hold_the_newest_observation_and_the_last_reference(
    rate: int, recorded: Recorded, tmp_path: Path
) -> None:
    write_dataset([recorded], tmp_path / "dataset", rate=rate)
    arrays, rows = recorded.arrays, rows_of(tmp_path / "dataset")
    times = arrays["time"].tolist()
    assert len(rows) == int(times[-1] * rate + 1e-4) + 1
    for frame, row in enumerate(rows):
        seen = [k for k, time in enumerate(times) if time <= frame / rate + 1e-5]
        until = [k for k, time in enumerate(times) if time < (frame + 1) / rate - 1e-5]
        last = frame == len(rows) - 1
        state, action = arrays["positions"][seen[-1]], arrays["references"]
        assert row["observation.state"] == pytest.approx(state, abs=1e-5)
        assert row["action"] == pytest.approx(action[-1 if last else until[-1]], abs=1e-5)
        loads = arrays["loads"][seen[-1]].ravel()
        assert row["observation.loads"] == pytest.approx(loads, abs=1e-4)


def test_images_are_the_newest_ones_without_loss(folder: Path, recorded: Recorded) -> None:
    times = recorded.arrays["image_time"]
    for row in rows_of(folder):
        index = max(int((times <= row["timestamp"] + 1e-5).sum()) - 1, 0)
        data = np.frombuffer(row["observation.images.left"]["bytes"], dtype=np.uint8)
        image = cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        assert np.array_equal(image, recorded.arrays["image_left"][index])


def test_reward_end_state_and_action_are_those_of_the_program(
    folder: Path, recorded: Recorded
) -> None:
    rows, passed = rows_of(folder), recorded.summary["transitions"]
    own = [row for row in passed if row["depth"] == 0]
    assert sum(row["next.reward"] for row in rows) == sum(row["reward"] for row in own) == 1
    assert [row["next.done"] for row in rows] == [False] * (len(rows) - 1) + [True]
    assert [row["next.success"] for row in rows] == [row["next.done"] for row in rows]
    for row in rows:
        ended = [each for each in own if each["time"] <= row["timestamp"] + 1e-5]
        assert row["program.state"] == (ended[-1]["next_state"] if ended else "XXX")
        later = own[len(ended) :]
        assert row["program.action"] == (later[0]["action"] if later else "")
    assert not any(row["next.success"] for row in rows_of(folder, 1)), "it was not rewarded"


def test_episodes_report_seed_context_and_ending(folder: Path, recorded: Recorded) -> None:
    first, second = episodes_of(folder)
    assert first["recording/seed"] == recorded.summary["result"]["seed"]
    assert first["recording/ending"] == recorded.summary["result"]["ending"]
    assert (second["recording/seed"], second["recording/rewarded"]) == (99, False)


def test_tasks_are_indexed_by_their_sentences(recorded: Recorded, tmp_path: Path) -> None:
    write_dataset([recorded], tmp_path / "dataset", task="Touch the ball.")
    table = pq.read_table(tmp_path / "dataset/meta/tasks.parquet")
    assert table.to_pylist() == [{"task_index": 0, "task": "Touch the ball."}]
    assert json.loads(table.schema.metadata[b"pandas"])["index_columns"] == ["task"]
    (episode,) = episodes_of(tmp_path / "dataset")
    assert episode["tasks"] == ["Touch the ball."]
    assert info_of(tmp_path / "dataset")["total_tasks"] == 1


def test_statistics_are_those_of_the_frames(folder: Path) -> None:
    stats = json.loads((folder / "meta/stats.json").read_text())
    features, table = info_of(folder)["features"], table_of(folder)
    assert stats.keys() == {n for n, each in features.items() if each["dtype"] != "string"}
    for name, row in stats.items():
        assert row["count"] == [table.num_rows]
        if features[name]["dtype"] == "image":
            stored = table[name].to_pylist()
            files = [np.frombuffer(each["bytes"], dtype=np.uint8) for each in stored]
            values = np.stack([cv2.imdecode(file, cv2.IMREAD_COLOR)[..., ::-1] for file in files])
            values = values.reshape(-1, 3) / 255
        else:
            values = np.array(table[name].to_pylist(), dtype=float).reshape(table.num_rows, -1)
        expected = {"min": np.min, "max": np.max, "mean": np.mean, "std": np.std}
        for key, function in expected.items():
            assert np.ravel(row[key]) == pytest.approx(function(values, axis=0), abs=1e-6), name
        median = np.quantile(values, 0.5, axis=0)
        assert np.ravel(row["q50"]) == pytest.approx(median, abs=1 / 255), name
        shape = (3, 1, 1) if features[name]["dtype"] == "image" else (values.shape[1],)
        assert np.shape(row["q99"]) == shape
    first, _ = episodes_of(folder)
    assert np.shape(first["stats/observation.images.left/mean"]) == (3, 1, 1)


def test_videos_show_the_images_of_each_episode(recorded: Recorded, tmp_path: Path) -> None:
    folder = tmp_path / "dataset"
    half = shortened(recorded, len(recorded.arrays["time"]) // 2)
    write_dataset([recorded, half], folder, rate=RATE, videos=True)
    exact = tmp_path / "exact"
    write_dataset([recorded, half], exact, rate=RATE)
    info, episodes, key = info_of(folder), episodes_of(folder), "observation.images.left"
    assert info["features"][key]["dtype"] == "video"
    assert info["features"][key]["info"]["video.fps"] == RATE
    assert key not in table_of(folder).column_names
    for number, episode in enumerate(episodes):
        place = {name: episode[f"videos/{key}/{name}"] for name in ("chunk_index", "file_index")}
        video = cv2.VideoCapture(str(folder / info["video_path"].format(video_key=key, **place)))
        assert video.get(cv2.CAP_PROP_FPS) == RATE
        assert episode[f"videos/{key}/from_timestamp"] == 0.0
        length = episode[f"videos/{key}/to_timestamp"] * RATE
        assert video.get(cv2.CAP_PROP_FRAME_COUNT) == episode["length"] == pytest.approx(length)
        for row in rows_of(exact, number):
            data = np.frombuffer(row[key]["bytes"], dtype=np.uint8)
            image = cv2.imdecode(data, cv2.IMREAD_COLOR).astype(float)
            shown, frame = video.read()
            assert shown and abs(frame - image).mean() < 3.0
    stats = [json.loads((each / "meta/stats.json").read_text()) for each in (folder, exact)]
    assert stats[0] == stats[1], "those of the images themselves"


def test_images_of_odd_size_become_no_video(recorded: Recorded, tmp_path: Path) -> None:
    arrays = {**recorded.arrays, "image_left": recorded.arrays["image_left"][:, :, 1:]}
    with pytest.raises(UsageError, match=r"even height and width, and images are 159 x 120"):
        write_dataset([replace(recorded, arrays=arrays)], tmp_path / "dataset", videos=True)
    assert list(tmp_path.iterdir()) == []


def test_recordings_of_other_sensors_are_refused(recorded: Recorded, tmp_path: Path) -> None:
    blind = {key: a for key, a in recorded.arrays.items() if key != "image_left"}
    other = replace(recorded, arrays=blind)
    with pytest.raises(UsageError, match=r"differs from .* in observation.images.left"):
        write_dataset([recorded, other], tmp_path / "dataset")
    assert list(tmp_path.iterdir()) == [], "nothing is left"
    summary = {**recorded.summary, "robot": {**recorded.summary["robot"], "name": "odd"}}
    with pytest.raises(UsageError, match="robot 'odd' instead of 'dexter'"):
        write_dataset([recorded, replace(recorded, summary=summary)], tmp_path / "dataset")


def test_write_dataset_with_name_that_is_not_utf8_is_refused(
    recorded: Recorded, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match="not UTF-8"):
        write_dataset([recorded], tmp_path / "kept\udcff" / "dataset", rate=RATE)


def test_only_datasets_are_replaced(recorded: Recorded, tmp_path: Path) -> None:
    precious = tmp_path / "photos"
    precious.mkdir()
    with pytest.raises(UsageError, match="already exists"):
        write_dataset([recorded], precious)
    with pytest.raises(UsageError, match="not a LeRobot dataset, and not replaced"):
        write_dataset([recorded], precious, overwrite=True)
    target = tmp_path / "dataset"
    write_dataset([recorded], target, rate=1)
    assert write_dataset([recorded], target, rate=2, overwrite=True)[0] == 1
    assert info_of(target)["fps"] == 2


def test_export_command_writes_all_recordings_of_a_folder(
    kept: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "dataset"
    words = ("export", "lerobot", str(kept.parent), "--out", str(out))
    assert cb(monkeypatch, *words) == 0
    assert "of 1 episode\n" in capsys.readouterr().out
    assert info_of(out)["fps"] == RATE, "the rate of the images"
    assert cb(monkeypatch, *words) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert cb(monkeypatch, *words, "--overwrite", "--fps", "999") == 2
    assert "60 ticks per second" in capsys.readouterr().err
    assert info_of(out)["fps"] == RATE, "what was there stays"


def test_signals_are_the_state_of_the_environment(recorded: Recorded, tmp_path: Path) -> None:
    names = sorted(k.removeprefix("signal_") for k in recorded.arrays if k.startswith("signal_"))
    values = {name: recorded.arrays[f"signal_{name}"] for name in names}
    undefined = dict(recorded.arrays)
    undefined[f"signal_{names[0]}"] = np.full_like(values[names[0]], np.nan)
    undefined[f"signal_{names[0]}"][-1] = 1.0
    recordings = [recorded, replace(recorded, arrays=undefined)]
    write_dataset(recordings, tmp_path / "data", rate=RATE, signals=names)
    feature = info_of(tmp_path / "data")["features"]["observation.environment_state"]
    assert feature["shape"] == [sum(each[0].size for each in values.values())]
    times = recorded.arrays["time"]
    for row in rows_of(tmp_path / "data"):
        tick = np.searchsorted(times, row["timestamp"] + 1e-6, side="right") - 1
        expected = np.concatenate([each[tick].ravel() for each in values.values()])
        np.testing.assert_allclose(row["observation.environment_state"], expected, rtol=1e-6)
    statistics = json.loads((tmp_path / "data/meta/stats.json").read_text())
    state = statistics["observation.environment_state"]
    assert np.isfinite([state["mean"], state["std"], state["q50"]]).all()


def test_signal_that_was_not_recorded_is_refused(recorded: Recorded, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"--signals stereo\.blue: .* has no such signal"):
        write_dataset([recorded], tmp_path / "data", rate=RATE, signals=["stereo.blue"])
