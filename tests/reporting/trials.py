"""Files as ``cb learn`` writes them, of trials with random walks."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from cbdsl.documents.document import Document
from cbdsl.documents.model import Gaussian, Kernel, ModelDocument
from cbdsl.documents.policy import Identity, PolicyDocument, Provenance
from cbdsl.yaml_text.writer import write
from tests.reporting.drawing.policies import ACTIONS, Walk, learned

_AFTER = {"XX": ("X0", "0X"), "X0": ("X1", "X-"), "0X": ("X0", "0X"), "X-": ("0X", "X0")}
_LONGEST = 12


def write_trial(
    folder: Path, name: str, seed: int = 0, episodes: int = 20, alpha: float = 0.1
) -> Path:
    """Write a trial's policy, two models and its journal, and return the policy's file."""
    rng = np.random.default_rng(seed)
    walks = [_walk(rng) for _ in range(episodes)]
    rows = [_row(walk, seed + place) for place, walk in enumerate(walks)]
    policy = learned(walks)
    rewards = [sum(each["reward"] for each in row["transitions"]) for row in rows]
    assert policy.curve is not None
    policy = policy.model_copy(
        update={
            "name": name,
            "models": {"head.uniform": f"{name}_head"},
            "curve": policy.curve.model_copy(update={"reward": tuple(rewards)}),
            "provenance": _provenance(seed, episodes, alpha),
        }
    )
    file = folder / f"{name}.yaml"
    _write_models(folder, name, rng)
    lines = [json.dumps(row) for row in ({"program": "walking"}, *rows)]
    file.with_suffix(".episodes.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
    write(PolicyDocument.model_validate(policy.model_dump()), file)
    return file


def _walk(rng: np.random.Generator) -> Walk:
    walk, state = [], "XX"
    while state != "X1" and len(walk) < _LONGEST:
        state = str(rng.choice(_AFTER[state]))
        walk.append((str(rng.choice(ACTIONS)), state))
    return walk


def _row(walk: Walk, seed: int) -> dict[str, object]:
    transitions = [
        {"program": "walking", "depth": 0, "time": 1.0, "state": "XX", "action": action,
         "next_state": after, "ticks": 60, "reward": int(after == "X1"),
         "rewarding": ["reach"] if after == "X1" else []}
        for action, after in walk
    ]  # fmt: skip
    return {"context": "near" if seed % 2 else "far", "seed": seed, "transitions": transitions,
            "rewarded": {}, "ticks": 60 * len(walk), "sim_seconds": float(len(walk)),
            "wall_seconds": 1.0}  # fmt: skip


def _write_models(folder: Path, name: str, rng: np.random.Generator) -> None:
    samples = tuple(map(tuple, rng.normal((0.3, 0.2), 0.2, (15, 2)).tolist()))
    densities = {
        "head": Kernel(form="kernel", samples=samples, bandwidth=(0.1, 0.1), uniform=0.4),
        "right_hand": Gaussian(
            form="gaussian", mean=(0.5, 1, 1, 1), deviation=(0.1, 0.2, 0.2, 0.3)
        ),
    }
    for effector, density in densities.items():
        document: Document = ModelDocument(
            cbdsl=1, kind="model", name=f"{name}_{effector}", robot="dexter", effector=effector,
            density=density,
        )  # fmt: skip
        write(document, folder / f"{name}_{effector}.yaml")


def _provenance(seed: int, episodes: int, alpha: float) -> Provenance:
    def named(name: str) -> Identity:
        return Identity(name=name, sha256="0123456789abcdef" * 4)

    return Provenance(
        command=f"cb learn walking --out walked.yaml --seed {seed}",
        program=named("walking"),
        actions=ACTIONS,
        robot=named("dexter"),
        stage=named("absent"),
        algorithm="accommodate",
        constants={"alpha": alpha},
        seed=seed,
        episodes=episodes,
        backend="kinematic",
        renderer="ideal cameras",
        versions={"cbdsl": "0.1.0"},
    )
