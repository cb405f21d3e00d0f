"""Provenance of knowledge: program, robot, stage, algorithm, constants, seed and versions."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from cbdsl.backends.backend import BACKENDS
from cbdsl.documents.digest import ProgramDigest, digest
from cbdsl.documents.document import Document
from cbdsl.documents.policy import Identity, Provenance
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.learner import LEARNERS
from cbdsl.training.trial import Trial
from cbdsl.types.registry import Registry

# What episodes and documents are computed with; those that are not installed had no part in it.
_PACKAGES = (
    "cbdsl", "moderngl", "numba", "numpy", "opencv-python-headless", "pin", "pybullet",
    "pybullet-arm64",
)  # fmt: skip
# What a backend of ours needs beside these.
_ENGINES = {"mujoco": "mujoco-core"}


@dataclass(frozen=True)
class TrialSetting:
    """Surroundings of a trial that its outcome depends on.

    Attributes:
        digest: of the program's text and of the policies that it uses.
        robot: what runs it.
        stage: where.
        backend: name of what embodies the robot.
        renderer: what makes its images.
    """

    digest: ProgramDigest
    robot: RobotDocument
    stage: StageDocument
    backend: str
    renderer: str


def provenance_of(trial: Trial, setting: TrialSetting, episodes: int, command: str) -> Provenance:
    """Provenance of a trial.

    Args:
        trial: what is learned, by which constants and chance.
        setting: where.
        episodes: how many.
        command: what learns it again.
    """
    program = trial.program
    limits = {
        "transitions": program.transitions,
        "transition_time": program.transition_time,
        "idle_time": program.idle_time,
        "episode_time": program.episode_time,
    }
    constants = trial.constants.model_dump() | limits
    return Provenance(
        command=command,
        program=Identity(name=program.name, sha256=setting.digest.sha256),
        policies=dict(setting.digest.policies),
        parameters=dict(program.parameters),
        actions=tuple(action.name for action in program.actions),
        robot=_identity(setting.robot),
        stage=_identity(setting.stage),
        algorithm=trial.algorithm,
        constants={name: value for name, value in constants.items() if value is not None},
        seed=trial.seed,
        trial=trial.number,
        episodes=episodes,
        backend=setting.backend,
        renderer=setting.renderer,
        versions=versions(setting.backend) | plugin_versions(trial.algorithm, setting.backend),
    )


def _identity(document: Document) -> Identity:
    return Identity(name=document.name, sha256=digest(document))


def plugin_versions(learner: str, backend: str) -> dict[str, str]:
    """Versions of the other packages that a learner and a backend come from."""
    registries: tuple[tuple[Registry[Any], str], ...] = ((LEARNERS, learner), (BACKENDS, backend))
    return dict(
        registry.distribution(name)
        for registry, name in registries
        if name in registry and not registry.is_builtin(name)
    )


def versions(backend: str = "") -> dict[str, str]:
    """Versions of the installed packages that an outcome on a backend, or any, depends on."""
    installed = {"python": platform.python_version()}
    for package in (*_PACKAGES, *([_ENGINES[backend]] if backend in _ENGINES else ())):
        try:
            installed[package] = version(package)
        except PackageNotFoundError:
            continue
    return installed
