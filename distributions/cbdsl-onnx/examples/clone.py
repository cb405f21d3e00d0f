"""Behaviour cloning of recordings, by numpy alone, into a small network in the ONNX format.

    cb run push_by_hand --backend mujoco --cameras ideal --episodes 150 --record tapes
    python clone.py push_thing tapes .

The network maps the tip and the seen object to the next velocities of the tip. It is a perceptron
with two hidden layers, trained by Adam on the squared error of normalised velocities.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml  # noqa: TID251 - the example stands alone
from numpy.typing import NDArray

from cbdsl_onnx import wire

Array = NDArray[np.float64]

MOVED = "right_arm.position"
STEPS, HIDDEN, UPDATES, BATCH, RATE = 4, 48, 8000, 128, 2e-3
#: Speed below which the skill waits between two of its ways, m/s.
WAITING = 0.05


class Skill(NamedTuple):
    """Skill of a recorded program.

    Attributes:
        program: Program that demonstrates it.
        actions: Names of its actions, in order.
        seen: Signal of the object.
        description: Sentence of the network's document.
        period: Time between two actions, s, at least that of a tick.
    """

    program: str
    actions: tuple[str, ...]
    seen: str
    description: str
    period: float = 0.05


SKILLS = {
    "reach_above": Skill(
        "reach_by_hand",
        ("reach",),
        "stereo.sat_10",
        "Velocities of the palm to a point above a seen object.",
    ),
    "push_thing": Skill(
        "push_by_hand",
        ("level ◁ above", "level ◁ behind", "level ◁ straight ◁ push"),
        "stereo.red",
        "Velocities of the palm down behind a seen thing, and to the left until it is at a line.",
    ),
}


def demonstrations(skill: Skill, folder: Path) -> Iterator[tuple[Array, Array]]:
    """Yield observations (n, 6), and velocities (n, 3), m/s, once a period.

    Only successful episodes count, and in them the ticks of the skill. Where it waits between two
    of its ways, they are left out, since a network without memory would learn to wait there.
    """
    for file in sorted(folder.glob("*.json")):
        summary = json.loads(file.read_text("utf-8"))
        if not summary["result"]["succeeded"]:
            continue
        passed = [row for row in summary["transitions"] if row["depth"] == 0]
        begin = next(row["time"] for row in passed if row["action"] == skill.actions[0])
        last = next(row["time"] for row in passed if row["action"] == skill.actions[-1])
        later = (r["time"] for r in passed if r["time"] > last and r["action"] != skill.actions[-1])
        arrays = np.load(file.with_suffix(".npz"))
        time = arrays["time"]
        chosen = np.flatnonzero((time >= begin) & (time < next(later, np.inf)))
        chosen = chosen[:: max(round(skill.period / float(np.diff(time).mean())), 1)]
        rows = np.hstack([arrays[f"signal_{name}"][chosen] for name in (MOVED, skill.seen)])
        velocities = np.diff(rows[:, :3], axis=0) / np.diff(time[chosen])[:, None]
        acts = (np.linalg.norm(velocities, axis=1) > WAITING) | (time[chosen[:-1]] >= last)
        yield rows[:-1][acts], velocities[acts]


def chunks(velocities: Array) -> Array:
    """Return the next velocities of each tick, shape (n, steps, 3); the last one is repeated."""
    padded = np.concatenate([velocities, np.repeat(velocities[-1:], STEPS, axis=0)])
    return np.stack([padded[k : k + len(velocities)] for k in range(STEPS)], axis=1)


def train(x: Array, y: Array, rng: np.random.Generator) -> list[Array]:
    """Return weights and biases of the layers, alternately, for normalised rows x and y."""
    sizes = (x.shape[1], HIDDEN, HIDDEN, y.shape[1])
    layers: list[Array] = []
    for inputs, outputs in pairwise(sizes):
        layers += [rng.normal(0.0, inputs**-0.5, (inputs, outputs)), np.zeros(outputs)]
    moments = [(np.zeros_like(layer), np.zeros_like(layer)) for layer in layers]
    for update in range(1, UPDATES + 1):
        batch = rng.integers(len(x), size=BATCH)
        slopes = gradients(layers, x[batch], y[batch])
        pace = RATE * (1.0 - update / UPDATES) + 1e-5
        for layer, slope, (first, second) in zip(layers, slopes, moments, strict=True):
            first += 0.1 * (slope - first)
            second += 0.001 * (slope**2 - second)
            scale = np.sqrt(second / (1.0 - 0.999**update)) + 1e-8
            layer -= pace * first / (1.0 - 0.9**update) / scale
    return layers


def gradients(layers: list[Array], x: Array, y: Array) -> list[Array]:
    """Return the derivatives of half the mean squared error by the layers."""
    values = [x]
    for place in range(0, len(layers), 2):
        value = values[-1] @ layers[place] + layers[place + 1]
        values.append(value if place == len(layers) - 2 else np.tanh(value))
    error = (values[-1] - y) / len(x)
    slopes: list[Array] = []
    for place in range(len(layers) - 2, -1, -2):
        before = values[place // 2]
        slopes[:0] = [before.T @ error, error.sum(axis=0)]
        error = (error @ layers[place].T) * (1.0 - before**2)
    return slopes


def written(layers: list[Array]) -> bytes:
    """Return the network as an ONNX model of a row `x` and a chunk `y`."""
    nodes, constants, last = [], [], "x"
    for place in range(0, len(layers), 2):
        number, is_last = place // 2, place == len(layers) - 2
        for name, array in (("w", layers[place]), ("b", layers[place + 1])):
            raw = array.astype("<f4").tobytes()
            constants.append(wire.tensor(f"{name}{number}", array.shape, raw))
        nodes.append(wire.node("MatMul", (last, f"w{number}"), f"product{number}"))
        sum_ = "y" if is_last else f"sum{number}"
        nodes.append(wire.node("Add", (f"product{number}", f"b{number}"), sum_))
        last = sum_
        if not is_last:
            last = f"hidden{number}"
            nodes.append(wire.node("Tanh", (sum_,), last))
    inputs = wire.value_info("x", (1, len(layers[0])))
    return wire.model(nodes, constants, [inputs], [wire.value_info("y", (1, len(layers[-1])))])


def main(name: str, tapes: Path, target: Path) -> None:
    """Train on recordings; write the model and its document into a folder."""
    skill = SKILLS[name]
    episodes = list(demonstrations(skill, tapes))
    x = np.concatenate([rows for rows, _ in episodes])
    y = np.concatenate([chunks(velocities) for _, velocities in episodes])
    x_mean, x_deviation = x.mean(axis=0), x.std(axis=0) + 1e-3
    y_deviation = y.std(axis=(0, 1)) + 1e-3
    normalised = ((x - x_mean) / x_deviation, (y / y_deviation).reshape(len(y), -1))
    layers = train(*normalised, np.random.default_rng(0))
    (target / f"{name}.onnx").write_bytes(written(layers))
    document = {
        "cbdsl": 1,
        "kind": "network",
        "name": name,
        "description": skill.description,
        "robot": "dexter",
        "file": f"{name}.onnx",
        "inputs": {
            "x": {
                "of": [MOVED, skill.seen],
                "mean": [round(float(each), 4) for each in x_mean],
                "deviation": [round(float(each), 4) for each in x_deviation],
            }
        },
        "output": {
            "name": "y",
            "of": MOVED,
            "gives": "velocity",
            "deviation": [round(float(each), 4) for each in y_deviation],
            "steps": STEPS,
            "execute": 2,
        },
        "period": f"{1e3 * skill.period:.0f} ms",
        "card": {
            "data": f"{len(episodes)} simulated episodes of {skill.program}, {len(x)} observations",
            "method": f"behaviour cloning by clone.py {name}, seed 0",
            "licence": "MIT",
        },
    }
    text = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=100)
    (target / f"{name}.yaml").write_text(text, "utf-8")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
