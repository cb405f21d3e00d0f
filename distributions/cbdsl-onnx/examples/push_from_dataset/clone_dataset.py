r"""Behaviour cloning of a LeRobot data set into an ONNX model, on signals or on images.

    cb run approach_by_hand.yaml --backend kinematic --cameras rendered --episodes 110 \
        --seed 10000 --record tapes
    cb export lerobot tapes --signals right_arm.position,stereo.red --fps 20 --out data
    python clone_dataset.py states data .
    python clone_dataset.py images data .

Both networks give the next velocities of the palm, which they see. The first one sees the object's
place, too; the second one sees the head's joints and an image of 96 x 96 pixels in its place.
Needs torch and onnx (``pip install torch onnx``). ``cb run`` needs neither for the ONNX model.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import pyarrow.parquet as pq
import torch
import yaml  # noqa: TID251 - the example stands alone
from numpy.typing import NDArray
from torch import nn

Floats = NDArray[np.float32]

MOVED, SEEN, HEAD, CAMERA = "right_arm.position", "stereo.red", ("pan", "tilt"), "left"
STEPS, SIZE, BATCH, RATE = 4, 96, 64, 2e-3
UPDATES = {"states": 4000, "images": 1500}
#: Speed below which a demonstration waits between two of its ways, m/s.
WAITING = 0.05
LAST_WAY = "level ◁ behind"


class Rows(NamedTuple):
    """Observations of demonstrations, and the velocities that follow them.

    Attributes:
        palm: Position of the palm, m, shape (n, 3).
        seen: Measured position of the object, m, shape (n, 3).
        head: Joints of the head, rad, shape (n, 2).
        images: RGB images, shape (n, 3, 96, 96).
        chunks: Next velocities of the palm, m/s, shape (n, steps, 3).
    """

    palm: Floats
    seen: Floats
    head: Floats
    images: NDArray[np.uint8]
    chunks: Floats


def demonstrations(folder: Path) -> Iterator[Rows]:
    """Yield the rows of each successful episode of a data set, format v3.0."""
    info = json.loads((folder / "meta/info.json").read_text("utf-8"))
    names = {name: each["names"] for name, each in info["features"].items()}
    columns = {
        key: [names[key].index(f"{name}.{end}") for name, ends in parts.items() for end in ends]
        for key, parts in (
            ("observation.environment_state", {MOVED: "012", SEEN: "012"}),
            ("observation.state", dict.fromkeys(HEAD, ("pos",))),
        )
    }
    for file in sorted(folder.glob("data/*/*.parquet")):
        for group in range(pq.ParquetFile(file).num_row_groups):  # one per episode
            table = pq.ParquetFile(file).read_row_group(group)
            if not table["next.success"][-1].as_py():
                continue
            numbers = {
                key: np.array(table[key].to_pylist(), np.float32)[:, places]
                for key, places in columns.items()
            }
            images = [
                _image(each["bytes"]) for each in table[f"observation.images.{CAMERA}"].to_pylist()
            ]
            places, head = numbers.values()
            yield _episode(
                places, head, np.stack(images), table["program.action"].to_pylist(), info["fps"]
            )


def _image(data: bytes) -> NDArray[np.uint8]:
    image = cv2.cvtColor(
        cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB
    )
    resized: NDArray[np.uint8] = cv2.resize(image, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
    return resized.transpose(2, 0, 1)


def _episode(
    places: Floats, head: Floats, images: NDArray[np.uint8], actions: list[str], rate: int
) -> Rows:
    """Return the rows in which the demonstration acts: a network without memory would wait, too."""
    velocities = np.diff(places[:, :3], axis=0) * rate
    is_last = np.array(actions[:-1]) == LAST_WAY
    acts = (np.linalg.norm(velocities, axis=1) > WAITING) | is_last
    acts &= np.isfinite(places[:-1]).all(axis=1)
    moves = velocities[acts]
    padded = np.concatenate([moves, np.zeros((STEPS, 3), np.float32)])
    chunks = np.stack([padded[k : k + len(moves)] for k in range(STEPS)], axis=1)
    kept = places[:-1][acts]
    return Rows(kept[:, :3], kept[:, 3:], head[:-1][acts], images[:-1][acts], chunks)


class Perceptron(nn.Sequential):
    """Perceptron with two hidden layers."""

    def __init__(self, inputs: int, outputs: int, hidden: int = 64) -> None:
        super().__init__(
            nn.Linear(inputs, hidden),
            nn.Tanh(),
            nn.Linear(hidden, hidden),
            nn.Tanh(),
            nn.Linear(hidden, outputs),
        )


class Eye(nn.Module):
    """Convolutions; a feature is the mean place of its response in the image, shape (n, 2 k)."""

    def __init__(self, features: int = 16) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Conv2d(3, 8, 5, stride=2),
            nn.ReLU(),
            nn.Conv2d(8, 16, 3, stride=2),
            nn.ReLU(),
            nn.Conv2d(16, features, 3),
        )
        side = self.layers(torch.zeros(1, 3, SIZE, SIZE)).shape[-1]
        axis = torch.linspace(-1.0, 1.0, side)
        grid = torch.stack(torch.meshgrid(axis, axis, indexing="ij"), dim=-1)
        self.register_buffer("grid", grid.reshape(-1, 2))

    def forward(self, images: torch.Tensor) -> torch.Tensor:
        """Return the features of images."""
        shares = torch.softmax(self.layers(images).flatten(2), dim=-1)
        return (shares @ self.grid).flatten(1)


class Follower(nn.Module):
    """Network of image and numbers; its second output, the object's place, helps its training."""

    def __init__(self, numbers: int) -> None:
        super().__init__()
        self.eye = Eye()
        features = self.eye(torch.zeros(1, 3, SIZE, SIZE)).shape[-1]
        self.place = Perceptron(features + 2, 3)
        self.move = Perceptron(features + numbers + 3, 3 * STEPS)

    def forward(self, image: torch.Tensor, x: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return velocities and the place of the object, normalised."""
        features = self.eye(image)
        place = self.place(torch.cat([features, x[:, 3:]], dim=1))
        return self.move(torch.cat([features, x, place], dim=1)), place


class Numbers(nn.Module):
    """Network of numbers."""

    def __init__(self, numbers: int) -> None:
        super().__init__()
        self.move = Perceptron(numbers, 3 * STEPS)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return velocities, normalised."""
        return self.move(x)


def train(kind: str, x: Floats, y: Floats, images: NDArray[np.uint8], seen: Floats) -> nn.Module:
    """Return a network trained on normalised rows by the squared error."""
    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    network = Follower(x.shape[1]) if kind == "images" else Numbers(x.shape[1])
    optimizer = torch.optim.Adam(network.parameters(), RATE)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, UPDATES[kind])
    for _ in range(UPDATES[kind]):
        rows = rng.integers(len(x), size=BATCH)
        numbers, wanted = torch.from_numpy(x[rows]), torch.from_numpy(y[rows])
        if kind == "images":
            given, place = network(torch.from_numpy(images[rows]).float() / 255.0, numbers)
            loss = ((place - torch.from_numpy(seen[rows])) ** 2).mean()
        else:
            given, loss = network(numbers), torch.zeros(())
        loss = loss + ((given - wanted) ** 2).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
    return network.eval()


def export(kind: str, network: nn.Module, numbers: int, file: Path) -> None:
    """Write a network as an ONNX model with the inputs `image` and `x` and the output `y`."""
    x, image = torch.zeros(1, numbers), torch.zeros(1, 3, SIZE, SIZE)
    is_image = kind == "images"
    torch.onnx.export(
        network,
        (image, x) if is_image else (x,),
        str(file),
        input_names=["image", "x"] if is_image else ["x"],
        output_names=["y", "place"] if is_image else ["y"],
        opset_version=17,
        dynamo=False,
    )


def normalisation(rows: Floats) -> tuple[Floats, Floats]:
    """Return mean and deviation of each component."""
    return rows.mean(axis=0), rows.std(axis=0) + np.float32(1e-3)


def rounded(numbers: Floats) -> list[float]:
    """Return numbers as a document has them."""
    return [round(float(number), 4) for number in numbers]


def main(kind: str, data: Path, target: Path) -> None:
    """Train on a data set; write the model and its document into a folder."""
    episodes = list(demonstrations(data))
    rows = Rows(*(np.concatenate(column) for column in zip(*episodes, strict=True)))
    other, name = (rows.head, "head") if kind == "images" else (rows.seen, SEEN)
    x = np.hstack([rows.palm, other])
    mean, deviation = normalisation(x)
    middle, spread = normalisation(rows.seen)
    speed = rows.chunks.std(axis=(0, 1)) + np.float32(1e-3)
    y = (rows.chunks / speed).reshape(len(x), -1)
    network = train(kind, (x - mean) / deviation, y, rows.images, (rows.seen - middle) / spread)
    title = f"approach_by_{kind}"
    export(kind, network, x.shape[1], target / f"{title}.onnx")
    inputs: dict[str, Any] = {
        "x": {"of": [MOVED, name], "mean": rounded(mean), "deviation": rounded(deviation)}
    }
    if kind == "images":
        inputs["image"] = {"of": [f"{CAMERA}.image"], "size": [SIZE, SIZE]}
    document = {
        "cbdsl": 1,
        "kind": "network",
        "name": title,
        "description": f"Velocities of the palm to a place behind a thing, from {kind}.",
        "robot": "dexter",
        "file": f"{title}.onnx",
        "inputs": inputs,
        "output": {
            "name": "y",
            "of": MOVED,
            "gives": "velocity",
            "deviation": rounded(speed),
            "steps": STEPS,
            "execute": 2,
        },
        "period": "50 ms",
        "card": {
            "data": f"{len(episodes)} episodes of approach_by_hand, {len(x)} observations",
            "method": f"behaviour cloning by clone_dataset.py {kind}, seed 0",
            "licence": "MIT",
        },
    }
    text = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=100)
    (target / f"{title}.yaml").write_text(text, "utf-8")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
