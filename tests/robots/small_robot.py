"""Robots of a few links, written to a folder, checked and run there."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from cbdsl.backends.simulated_backend import SimulatedBackend, simulate
from cbdsl.checking.program import check_program
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.yaml_text.library import Library

CONTROL = """
control:
  rate: 60 Hz
  tasks:
    configuration: {gain: 4 /s, speed: 1.4 rad/s, quiescence: {rate: 1e-3, window: 0.3 s}}
    position: {gain: 4 /s, speed: 35 cm/s, quiescence: {rate: 1e-4, window: 0.3 s}}
"""
_INERTIA = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
_BODY = (
    f'<inertial><origin xyz="0.1 0 0"/><mass value="1"/>{_INERTIA}</inertial><collision>'
    '<origin xyz="0.1 0 0"/><geometry><box size="0.1 0.02 0.02"/></geometry></collision>'
)
LIMIT = '<limit lower="-2" upper="2" effort="50" velocity="3"/>'


class Hinge(NamedTuple):
    """A joint of a planar chain: its type, and elements within it."""

    kind: str = "revolute"
    inner: str = LIMIT


def chain(*hinges: Hinge) -> str:
    """Return a URDF of joints j1, j2, … about z that move links l1, l2, …, each 0.25 m long."""
    links = [f'<link name="l{i}">{_BODY}</link>' for i in range(1 + len(hinges))]
    joints = [
        f'<joint name="j{i}" type="{hinge.kind}"><parent link="l{i - 1}"/><child link="l{i}"/>'
        f'<origin xyz="0.25 0 0"/><axis xyz="0 0 1"/>{hinge.inner}</joint>'
        for i, hinge in enumerate(hinges, start=1)
    ]
    return f'<robot name="small">{"".join(links)}{"".join(joints)}</robot>'


class SmallRobot(NamedTuple):
    """Files of a robot in a folder of its own.

    Attributes:
        folder: Folder with ``small.urdf`` and ``robots/small.yaml``.
        document: Robot document.
    """

    folder: Path
    document: RobotDocument

    @property
    def urdf(self) -> Path:
        """Path of the model."""
        return self.folder / "small.urdf"

    def kinematics(self) -> Kinematics:
        """Return the robot's kinematics."""
        return Kinematics(self.document, self.urdf)

    @contextmanager
    def backend(self, engine: str) -> Iterator[SimulatedBackend]:
        """Open the robot on an engine, without cameras."""
        backend = simulate(engine, self.document, self.urdf, cameras="ideal")
        yield backend
        backend.close()

    def run(self, backend: SimulatedBackend, controllers: str, seed: int = 1) -> EpisodeResult:
        """Run the controller ``move`` in an empty stage until it rests."""
        file = self.folder / "programs" / "go.yaml"
        file.parent.mkdir(exist_ok=True)
        file.write_text(
            "cbdsl: 1\nkind: program\nname: go\nrobot: small\n"
            f'controllers:\n  {controllers}\nactions: [move]\npolicy: {{X: move, "0": move}}\n',
            encoding="utf-8",
        )
        program = check_program(file, {}, Library(self.folder))
        runner = Runner(self.document, self.kinematics(), program, backend)
        return runner.run(self.stage(), seed)

    def stage(self) -> StageDocument:
        """Return an empty stage."""
        head = {"cbdsl": 1, "kind": "stage", "name": "empty", "robot": "small"}
        return StageDocument.model_validate({**head, "contexts": {"only": {}}})


def write_robot(folder: Path, urdf: str, rest: str) -> SmallRobot:
    """Write a robot named ``small`` with the rest of its document, such as its effectors."""
    (folder / "small.urdf").write_text(urdf, encoding="utf-8")
    file = folder / "robots" / "small.yaml"
    file.parent.mkdir()
    head = "cbdsl: 1\nkind: robot\nname: small\nmodel: ../small.urdf\nbase: l0\n"
    file.write_text(f"{head}{rest}\n{CONTROL}", encoding="utf-8")
    document = Library(folder).read(file, RobotDocument).document
    return SmallRobot(folder, document)
