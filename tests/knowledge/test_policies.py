"""Shipped learned policies belong to the current programs, and achieve their goals."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cbdsl.backends.backend import Backend, embody
from cbdsl.backends.bullet.backend import BulletBackend
from cbdsl.backends.kinematic.backend import KinematicBackend
from cbdsl.checking.document import check_document
from cbdsl.checking.knowledge.policy_agreement import with_policy
from cbdsl.checking.knowledge.program_digest import program_digest
from cbdsl.checking.session import Session
from cbdsl.documents.model import MODEL
from cbdsl.documents.policy import POLICY, PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.robot import RobotDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.kinematics import Kinematics
from cbdsl.runtime.episode import Runner
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.yaml_text.library import Library
from tests.conftest import ROOT, Checked

StageNamed = Callable[[str], StageDocument]
Play = Callable[[Backend, str, int], EpisodeResult]

POLICIES = sorted((ROOT / POLICY.folder).glob("*.yaml"))
MODELS = sorted((ROOT / MODEL.folder).glob("*.yaml"))
NAMES = [path.stem for path in POLICIES]

# For these, the force of an object on its support decides, which needs forces.
PHYSICAL = {"pick_and_place"}
# These contexts of training stages are unrewarded.
HOPELESS = {"absent"}
SEEDS = range(82_001, 82_007)
# Those whose states do not depend on how far things give way. Of these episodes one is left out:
# on bullet, fingers grip a ball askew in it that cannot give way, as the experimenter holds it.
SAME = ("reachtouch", "searchtrack", "searchtrack_table")
# In 82_003 the object is out of reach: after 17 equal states an engine loses sight of it first.
APART = ((SAME[0], 82_003), (SAME[0], 82_004))
EPISODES = [(name, seed) for name in SAME for seed in SEEDS if (name, seed) not in APART]


@pytest.fixture(scope="module")
def kinematic(dexter: RobotDocument, urdf: Path) -> Iterator[KinematicBackend]:
    backend = KinematicBackend(dexter, urdf)
    yield backend
    backend.close()


@pytest.fixture(scope="module")
def learned(library: Library) -> Callable[[str], PolicyDocument]:
    def read(name: str) -> PolicyDocument:
        return library.read(library.locate(PolicyDocument, name), PolicyDocument).document

    return read


@pytest.fixture(scope="module")
def play(
    dexter: RobotDocument,
    kinematics: Kinematics,
    library: Library,
    checked: Checked,
    stage: StageNamed,
) -> Play:
    """Return a function that runs an episode of a policy in the context of its learning."""

    def run(backend: Backend, name: str, seed: int) -> EpisodeResult:
        loaded = library.read(library.locate(PolicyDocument, name), PolicyDocument)
        assert loaded.document.provenance is not None
        program = with_policy(checked(loaded.document.program), loaded, library)
        runner = Runner(dexter, kinematics, program, backend)
        return runner.run(stage(loaded.document.provenance.stage.name), seed)

    return run


@pytest.mark.parametrize("path", [*POLICIES, *MODELS], ids=lambda path: path.stem)
def test_shipped_policy_has_no_diagnostics(path: Path) -> None:
    assert check_document(path, session=Session(Library(ROOT))) == []


def test_every_model_belongs_to_a_policy(learned: Callable[[str], PolicyDocument]) -> None:
    used = {model for name in NAMES for model in learned(name).models.values()}
    assert used <= {path.stem for path in MODELS}


@pytest.mark.parametrize("name", NAMES)
def test_command_in_the_provenance_repeats_the_policy(
    learned: Callable[[str], PolicyDocument], name: str
) -> None:
    document = learned(name)
    provenance = document.provenance
    assert provenance is not None and document.curve is not None
    words = shlex.split(provenance.command)
    assert words[:3] == ["cb", "learn", document.program]
    assert words[words.index("--out") + 1] == f"{name}.yaml"
    assert words[words.index("--seed") + 1] == str(provenance.seed)
    assert len(document.curve.reward) == provenance.episodes


@pytest.mark.parametrize("name", NAMES)
def test_provenance_of_a_policy_names_the_policies_of_used_programs(
    library: Library, learned: Callable[[str], PolicyDocument], name: str
) -> None:
    document = learned(name)
    assert document.provenance is not None
    program = library.locate(ProgramDocument, document.program)
    assert document.provenance.policies == program_digest(program, library).policies


def test_learned_skill_uses_learned_policies_of_its_parts(
    library: Library, learned: Callable[[str], PolicyDocument]
) -> None:
    """Run no hand-written table inside of a skill whose parts have been learned."""
    known = {learned(name).program for name in NAMES}
    for name in known:
        file = library.read(library.locate(ProgramDocument, name), ProgramDocument)
        written = [
            key
            for key, use in file.document.use.items()
            if use.program in known and use.policy is None
        ]
        assert written == [], f"{name} uses {written} without what was learned of them"


def require_sense(result: EpisodeResult) -> None:
    """Require reward where something can be won, and nowhere else."""
    assert result.rewarded == (result.context not in HOPELESS), result.ending


@pytest.mark.parametrize("name", sorted({*NAMES} - PHYSICAL))
def test_a_policy_runs(kinematic: KinematicBackend, play: Play, name: str) -> None:
    for seed in (81_001, 81_002):
        require_sense(play(kinematic, name, seed))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(PHYSICAL))
def test_policy_of_a_carrying_program_runs_on_mujoco(
    dexter: RobotDocument, urdf: Path, play: Play, name: str
) -> None:
    pytest.importorskip("mujoco")
    backend = embody("mujoco", dexter, urdf, cameras="ideal")
    for seed in (81_001, 81_002, 81_003):
        require_sense(play(backend, name, seed))
    backend.close()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), EPISODES)
def test_policy_passes_the_same_states_on_both_backends(
    bullet: BulletBackend, kinematic: KinematicBackend, play: Play, name: str, seed: int
) -> None:
    one, other = play(bullet, name, seed), play(kinematic, name, seed)
    assert other.context == one.context
    assert other.predicates == one.predicates, f"{one.ending} / {other.ending}"
    assert other.actions == one.actions
    require_sense(one)


@pytest.mark.slow
def test_probing_fingers_are_rewarded_on_both_backends(
    bullet: BulletBackend, kinematic: KinematicBackend, play: Play
) -> None:
    """Allow different states: fingers give way differently, and rarely get stuck."""
    for backend in (bullet, kinematic):
        rewarded = [play(backend, "tactileprobe", seed).rewarded for seed in SEEDS]
        assert sum(rewarded) >= len(rewarded) - 2


@pytest.mark.slow
@pytest.mark.parametrize("name", ["visualinspect", "bimanualtouch"])
def test_holding_programs_are_rewarded_on_bullet_and_kinematic(
    bullet: BulletBackend, kinematic: KinematicBackend, play: Play, name: str
) -> None:
    """Allow different states: fingers and objects give way differently."""
    for backend in (bullet, kinematic):
        rewarded = [play(backend, name, seed).rewarded for seed in SEEDS]
        assert sum(rewarded) >= len(rewarded) - 1
