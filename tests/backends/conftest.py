"""Dexter in every backend with an engine, and stages made for tests."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import moderngl
import pytest

from cbdsl.backends import backend as backends
from cbdsl.backends.backend import BackendError
from cbdsl.backends.engines import installed_engines
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.checking.stage.fitted_stage import fitted_stage
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.sensing.observation import Loads
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT

URDF = ROOT / "robots" / "dexter.urdf"
LIBRARY = Library(ROOT)

#: Names of the backends that need no robot beside them.
SELF_CONTAINED = tuple(
    name
    for name in backends.BACKENDS.usable_names()
    if not hasattr(backends.BACKENDS.get(name), "attend")
)
Simulated = SimulatedBackend[Any]
BACKENDS: dict[str, type[Simulated]] = {
    name: backend
    for name in installed_engines()
    if (backend := backends.BACKENDS.get(name))
    and isinstance(backend, type)
    and issubclass(backend, SimulatedBackend)
}


def stage_named(name: str) -> StageDocument:
    loaded = LIBRARY.read(LIBRARY.locate(StageDocument, name), StageDocument)
    # A stage for any robot is that before the Panda.
    return fitted_stage(loaded, robot_named("panda"), LIBRARY.locate(RobotDocument, "panda"))


def robot_named(name: str) -> RobotDocument:
    return LIBRARY.read(LIBRARY.locate(RobotDocument, name), RobotDocument).document


def made_stage(context: dict[str, Any], **parts: Any) -> StageDocument:
    """Return a stage with one context, ``only``."""
    head = {"cbdsl": 1, "kind": "stage", "name": "made", "robot": "dexter"}
    return StageDocument.model_validate({**head, "contexts": {"only": context}, **parts})


def with_vision(robot: RobotDocument, **changes: Any) -> RobotDocument:
    return robot.model_copy(update={"vision": robot.vision.model_copy(update=changes)})


def exact(robot: RobotDocument) -> RobotDocument:
    """Return a robot whose sensors have no steps, noise, bias, drift or latency."""
    contact = robot.contact.model_copy(update={"noise": 0.0, "bias": 0.0, "drift": 0.0})
    effectors = {
        name: effector.model_copy(update={"resolution": 0.0})
        for name, effector in robot.effectors.items()
    }
    changed = robot.model_copy(update={"contact": contact, "effectors": effectors})
    return with_vision(changed, noise=0.0, latency=0.0)


def sightless(robot: RobotDocument) -> RobotDocument:
    """Return a robot with exact sensors and no images."""
    return with_vision(exact(robot).model_copy(update={"cameras": {}}), renderer="tiny")


def contact_loads(backend: Simulated) -> Loads:
    """Return the loads that load cells would measure without tip weight and bias."""
    return backend._cells.read()


def run(backend: Simulated, seconds: float) -> None:
    for _ in range(round(seconds / backend.control_period)):
        backend.step()


@pytest.fixture(scope="session", params=list(BACKENDS))
def make(request: pytest.FixtureRequest) -> type[Simulated]:
    """Return the class of each backend."""
    return BACKENDS[request.param]


@pytest.fixture(scope="session")
def simulated(make: type[Simulated], dexter: RobotDocument) -> Iterator[Simulated]:
    """Yield each backend, with any renderer that works here."""
    backend = make(dexter, URDF)
    yield backend
    backend.close()


@pytest.fixture(scope="session")
def unseeing(make: type[Simulated], dexter: RobotDocument) -> Iterator[Simulated]:
    """Yield each backend without cameras and without load cell noise."""
    backend = make(sightless(dexter), URDF)
    yield backend
    backend.close()


@pytest.fixture(scope="session")
def opengl() -> None:
    """Skip where OpenGL is missing, because the slower renderer shows small regions coarsely."""
    try:
        moderngl.create_context(standalone=True, backend="egl").release()
    except Exception as error:
        pytest.skip(f"OpenGL is missing: {error}")


@pytest.fixture(scope="module", params=["opengl", "tiny", "mujoco"])
def rendered(dexter: RobotDocument, request: pytest.FixtureRequest) -> Iterator[Simulated]:
    """Yield a backend with each renderer that works here."""
    name = "mujoco" if request.param == "mujoco" else "bullet"
    if name not in BACKENDS:
        pytest.skip(f"{name} is not installed")
    engine = BACKENDS[name]
    try:
        backend = engine(with_vision(exact(dexter), renderer=request.param), URDF)
    except BackendError as error:
        pytest.skip(str(error))
    yield backend
    backend.close()
