"""Programs in the place of a member wait for their composition, and are rewarded for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.checking.program import examine_program
from cbdsl.checking.schema import checked_schema
from cbdsl.checking.session import Session
from cbdsl.diagnostics.diagnostics import Diagnostics
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.schema import SchemaDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_observer import EpisodeListeners
from cbdsl.runtime.policies.schema_policy import SchemaPolicy
from cbdsl.yaml_text.library import Library

SCHEMA = """\
cbdsl: 1
kind: schema
name: probing
program: reachtouch
policy: reachtouch
features: {place: stereo.$feature}
look: {place: {program: searchtrack, policy: searchtrack_table, with: {feature: $feature}}}
allocations:
  probe: {arm: right_arm, hand: right_hand, touch: tactileprobe}
choose: probe
otherwise: [probe]
"""
SEED = 8420000


@pytest.fixture(scope="module")
def schema(tmp_path_factory: pytest.TempPathFactory) -> CheckedProgram:
    path = tmp_path_factory.mktemp("schema") / "knowledge" / "schemas" / "probing.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(SCHEMA, encoding="utf-8")
    library = Library(path.parents[2])
    session = Session(library)
    program = checked_schema(
        library.read(path, SchemaDocument),
        session,
        Diagnostics(),
        lambda file, with_, own: examine_program(file, with_, session, own),
    )
    assert program is not None
    return program


@pytest.fixture
def episode(
    dexter: RobotDocument,
    urdf: Path,
    kinematics: Kinematics,
    stage: Callable[[str], StageDocument],
    schema: CheckedProgram,
) -> list[Transition]:
    """Return the transitions of a rewarded episode."""
    backend = KinematicBackend(dexter, urdf)
    policy = SchemaPolicy(schema, gives_up=False, persists=True)
    runner = Runner(dexter, kinematics, schema, backend, policy)
    for seed in range(SEED, SEED + 10):
        transitions: list[Transition] = []
        result = runner.run(
            stage("table_right"),
            seed,
            "out_of_view",
            observer=EpisodeListeners(on_transition=transitions.append),
        )
        if result.rewarded:
            break
    backend.close()
    return transitions


def test_program_is_rewarded_for_the_member(episode: list[Transition]) -> None:
    own = [each for each in episode if each.program == "reachtouch"]
    probing = [each for each in episode if each.program == "tactileprobe"]
    assert own[-1].next_state == "X11" and own[-1].rewarding == ("touch",)
    assert probing[-1].reward and probing[-1].depth == 1
    # It begins when the reach has come to rest, and was undefined until then.
    arrived = next(each for each in own if each.next_state == "X10")
    assert arrived.state[1:] in ("0-", "--") and probing[0].time <= arrived.time + 0.1
    assert not [each for each in probing if each.time < arrived.time - 0.1]


def test_schema_looks_for_features_before_it_allocates(episode: list[Transition]) -> None:
    first = next(each for each in episode if each.depth == 0)
    assert {"place.x", "place.y", "place.z"} <= first.features.keys()
    looked = [each for each in episode if each.time < first.time]
    assert {each.program for each in looked} == {"searchtrack"}
    assert looked[-1].reward
