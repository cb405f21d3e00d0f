"""Provenance of knowledge: program, robot, stage, algorithm, constants, seed and versions."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from cbdsl.backends.backend import BACKENDS
from cbdsl.documents.document import Document
from cbdsl.documents.document_digest import ProgramDigest, digest
from cbdsl.documents.policy import Identity, Provenance
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.learning.learner import LEARNERS
from cbdsl.training.trial import Trial
from cbdsl.types.registry import Registry

# Packages that episodes and documents are computed with, if installed.
_PACKAGES = (
    "cbdsl", "moderngl", "numba", "numpy", "opencv-python-headless", "pin", "pybullet",
    "pybullet-arm64",
)  # fmt: skip
# Additional packages of built-in backends.
_ENGINES = {"mujoco": "mujoco-core"}


@dataclass(frozen=True)
class TrialSetting:
    """Surroundings of a trial that influence its outcome.

    Attributes:
        digest: Digest of the program's text and of the policies that it uses.
        robot: Robot that runs the program.
        stage: Stage of the episodes.
        backend: Name of the backend.
        renderer: Name of the renderer of the images.
        origin: Robot that learned the policy, if another one did.
    """

    digest: ProgramDigest
    robot: RobotDocument
    stage: StageDocument
    backend: str
    renderer: str
    origin: Identity | None = None


def provenance_of(trial: Trial, setting: TrialSetting, episodes: int, command: str) -> Provenance:
    """Return the provenance of a trial.

    Args:
        trial: Trial with its program, constants and seed.
        setting: Surroundings of the trial.
        episodes: Number of episodes.
        command: Command that repeats the trial.
    """
    program = trial.program
    # A trial may have other limits than the program's text, whose digest does not cover them.
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
        programs=dict(setting.digest.programs),
        shared=dict(setting.digest.shared),
        earlier=None if trial.earlier is None else _identity(trial.earlier),
        parameters=dict(program.parameters),
        actions=tuple(action.name for action in program.actions),
        robot=_identity(setting.robot),
        origin=setting.origin,
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
    """Return the versions of the plug-in packages that provide a learner and a backend."""
    registries: tuple[tuple[Registry[Any], str], ...] = ((LEARNERS, learner), (BACKENDS, backend))
    return dict(
        registry.distribution(name)
        for registry, name in registries
        if name in registry and not registry.is_builtin(name)
    )


def versions(backend: str = "") -> dict[str, str]:
    """Return the versions of packages that influence an outcome; a backend adds its engine."""
    installed = {"python": platform.python_version()}
    for package in (*_PACKAGES, *([_ENGINES[backend]] if backend in _ENGINES else ())):
        try:
            installed[package] = version(package)
        except PackageNotFoundError:
            continue
    return installed
