"""Judge of ``cb why``: episodes with injected causes, and the first causes that it names.

``python -m benchmarks.first_causes --seeds 20`` runs the judged programs. Explanations were
developed with ``--set developed``, which has other programs. Injections act through programs,
stages, and the simulated backend; ``cb why`` reads recordings alone.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

import cbdsl
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.kinematics.pose import Pose
from cbdsl.numeric.proportion import exact_interval
from cbdsl.reporting.recorded import read_recording
from cbdsl.runtime.episode import EpisodeError
from cbdsl.runtime.episode_observer import EpisodeObserver, EpisodeObservers
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.explanation import named_runs
from cbdsl.runtime.recording import Recording
from cbdsl.runtime.tick import Tick
from cbdsl.sensing.observation import Observation
from cbdsl.yaml_text.library import Library
from cbdsl_why.diagnosis import diagnose
from cbdsl_why.history import History

Edits = Mapping[str, Sequence[tuple[str, str]]]
#: The seven kinds of FailGen (AHA, arXiv 2410.00371).
PUBLISHED = (
    "no_grasp", "slip", "translation", "rotation", "no_rotation", "wrong_order", "wrong_object",
)  # fmt: skip
# Difference of the first tick from the injection that counts as right, s.
_NEAR = 0.2
# Tick-wise injections act from this time on, s.
_LATER = 1.5


class WorldFault(EpisodeObserver):
    """Fault of the world or the backend, injected between two control ticks.

    Attributes:
        time: Time of the first injection, s; ``None`` before it.
        repeats: True if it is injected whenever it is due.
    """

    repeats = False

    def __init__(self, backend: SimulatedBackend[Any]) -> None:
        self.backend, self.engine = backend, backend.truth
        self.time: float | None = None

    def note_tick(self, tick: Tick) -> None:
        """Inject the fault when it is due."""
        if (self.time is None or self.repeats) and self.is_due(tick):
            self.time = tick.observation.time if self.time is None else self.time
            self.inject()

    def is_due(self, tick: Tick) -> bool:
        """Return whether the fault is due in a tick."""
        return tick.observation.time >= _LATER

    def inject(self) -> None:
        """Inject the fault."""
        raise NotImplementedError

    def take_away(self, distance: float) -> None:
        """Put the first object elsewhere on its level, by a distance, m."""
        name = self.engine.names()[-1]
        pose = self.engine.pose(name)
        self.engine.put_back(
            name, Pose(pose.position + np.array([0.0, distance, 0.0]), pose.rotation)
        )


class Removal(WorldFault):
    """Removal of the object during the approach."""

    def inject(self) -> None:
        self.engine.remove(self.engine.names()[-1])


class InjectedSlip(WorldFault):
    """Object that leaves the hand whenever the hand has moved it for half a second."""

    repeats, _held = True, 0

    def is_due(self, tick: Tick) -> bool:
        moves = ("up", "move", "carry")
        runs = named_runs(tick.run)
        is_moving = any(n.split(".")[-1] in moves and r.predicate == "0" for n, r in runs)
        self._held = self._held + 1 if is_moving else 0
        return self._held > 0.5 / self.backend.control_period

    def inject(self) -> None:
        self.take_away(0.25)


class FrozenJoint(WorldFault):
    """Drive of one joint of the arm that stops."""

    def inject(self) -> None:
        joints = [n for n, j in enumerate(self.backend._joints.names) if j.endswith(("_4", "4"))]
        joint, apply = joints[-1], self.backend.apply
        frozen = float(self.backend.observe().positions[joint])

        def applied(reference: Any) -> None:
            changed = np.array(reference, dtype=float)
            changed[joint] = frozen
            apply(changed)

        self.backend.apply = applied  # type: ignore[method-assign]


class Halt(WorldFault):
    """Sensor that gives no number any more."""

    def inject(self) -> None:
        observe = self.backend.observe

        def broken() -> Any:
            observation = observe()
            return replace(observation, positions=np.full_like(observation.positions, np.nan))

        self.backend.observe = broken  # type: ignore[method-assign]


class OneEye(WorldFault):
    """Camera that sees nothing from the beginning."""

    def __init__(self, backend: SimulatedBackend[Any]) -> None:
        super().__init__(backend)
        observe = self.backend.observe

        def half() -> Any:
            observation = observe()
            if not observation.regions:
                return observation
            blind = next(iter(observation.regions))
            return replace(observation, regions={**observation.regions, blind: {}})

        self.backend.observe = half  # type: ignore[method-assign]

    def inject(self) -> None:
        """Leave the world as it is."""


class Distortion(WorldFault):
    """Sensors that read otherwise from the beginning."""

    def __init__(
        self, change: Callable[[Observation], Observation], backend: SimulatedBackend[Any]
    ) -> None:
        super().__init__(backend)
        observe = self.backend.observe
        self.backend.observe = lambda: change(observe())  # type: ignore[method-assign]

    def inject(self) -> None:
        """Leave the world as it is."""


def _scaled_loads(factor: float) -> Callable[[Observation], Observation]:
    return lambda seen: replace(seen, loads={c: factor * load for c, load in seen.loads.items()})


def _drifting_loads(seen: Observation) -> Observation:
    drift = np.array([0.0, 0.0, 0.5 * seen.time, 0.0, 0.0, 0.0])
    return replace(seen, loads={cell: load + drift for cell, load in seen.loads.items()})


def _offset_joint(seen: Observation) -> Observation:
    positions = seen.positions.copy()
    positions[1] += 0.1
    return replace(seen, positions=positions)


def _shifted_rows(seen: Observation) -> Observation:
    """Shift the rows of one camera by 25 px, as if it had turned in its mount."""
    if not seen.regions:
        return seen
    camera, channels = next(iter(seen.regions.items()))
    moved = {n: tuple(r._replace(row=r.row + 25.0) for r in of) for n, of in channels.items()}
    return replace(seen, regions={**seen.regions, camera: moved})


class StaleImages:
    """Cameras that repeat their first images."""

    def __init__(self) -> None:
        self._first: Mapping[str, Any] = {}

    def __call__(self, seen: Observation) -> Observation:
        """Return an observation with the first regions in place of later ones."""
        if not seen.regions:
            return seen
        self._first = self._first or seen.regions
        return replace(seen, regions=self._first)


class Injection(NamedTuple):
    """Injected cause of a failure.

    Attributes:
        kind: Expected kind of the first cause; empty for a cause that is not on the list.
        program: Name of the program.
        edits: Replacements in the texts of programs and stages, by their names.
        fault: Fault of world or backend, if any.
        stage: Name of the stage; empty for the program's.
    """

    kind: str
    program: str
    edits: Edits = MappingProxyType({})
    fault: Callable[[SimulatedBackend[Any]], WorldFault] | None = None
    stage: str = ""


_PICK, _TOUCH, _PANDA = "pick_and_lift", "reachtouch", "pick"
_STAGE = "cube_on_bench"
_STEPS = (
    "  reachtouch: {then: ease, failed: back_off}\n  ease: {then: grip}\n"
    "  grip: {exits: [grip at rest: lift], failed: back_off}\n"
)
_SWAPPED = (
    "  grip: {exits: [grip at rest: ease], failed: back_off}\n  ease: {then: reachtouch}\n"
    "  reachtouch: {then: lift, failed: back_off}\n"
)
_RETRY, _AGAIN = "[back_off at rest: reachtouch]", "[back_off at rest: grip]"
_SEEN = "    reference: $eyes.$feature\n"
_OFF = '    reference: "stereo.$feature + [0 cm, {} cm, 0 cm]"\n'
_DOWN = "    reference: [180 deg, 0 deg, 0 deg]\n"
_TILTED = "    reference: [130 deg, 0 deg, 0 deg]\n"
# A taller block close beside the cube, on which fingers close as well.
_GRASP, _TABLE, _SIDE = "grasp", "things_on_table", "take_from_side"
_BLOCK = "  block: {form: {shape: box, size: [8 cm, 8 cm, 13 cm]}, mass: 2 kg, color: [0, 0, 1]}\n"
_BESIDE = (
    "  cube:\n    joints: {pan: [-0.65 rad, -0.25 rad], tilt: 1 rad}\n    placed:\n"
    "      cube: {things: [cube], place: {on: table, x: [45 cm, 60 cm], y: [-30 cm, -15 cm]}}\n"
    "      block: {things: [block], place: {beside: {name: cube, by: 9 cm}}}\n"
)
_TOP = "  reach: posture ◁ orient ◁ approach\n"
_BELOW = "  reach: orient ◁ approach ◁ posture\n"

#: Injections with which explanations were developed.
DEVELOPED = (
    Injection("no_grasp", _PICK, {_TOUCH: [("2 cm, until: $hand.shut", "2 cm, until: 0.4 rad")]}),
    Injection("slip", _PICK, fault=InjectedSlip),
    Injection("translation", _PICK, {_TOUCH: [(_SEEN, _OFF.format(14))]}),
    Injection("rotation", _PICK, {_TOUCH: [(_DOWN, _TILTED)]}),
    Injection("wrong_order", _PICK, {_PICK: [(_STEPS, _SWAPPED), (_RETRY, _AGAIN)]}),
    Injection("never_seen", "reach", stage="absent"),
    Injection("lost", _PICK, fault=Removal),
    Injection("occluded", _PICK, fault=OneEye),
    Injection("out_of_reach", "reach", stage="out_of_reach"),
    Injection("no_action", _PICK, {_TOUCH: [("  X0*: reach ◁ touch\n", "")]}),
    Injection("time", _PICK, {_PICK: [("episode_time: 90 s", "episode_time: 4 s")]}),
    Injection("not_followed", _PICK, fault=FrozenJoint),
    Injection("backend", _PICK, fault=Halt),
)

#: Injections into programs that were not used for the development.
JUDGED = (
    Injection("no_grasp", _PANDA, {_TOUCH: [("until: $hand.shut", "until: 30 mm")]}),
    Injection("slip", _PANDA, fault=InjectedSlip),
    Injection("slip", _PANDA, {_STAGE: [("mass: 100 g", "mass: 100 g, friction: 0.02")]}),
    Injection("translation", _PANDA, {_TOUCH: [(_SEEN, _OFF.format(12))]}),
    Injection("rotation", _PANDA, {_TOUCH: [(_DOWN, _TILTED)]}),
    Injection(
        "rotation",
        _SIDE,
        {_SIDE: [("    reference: stereo.$feature.on.$goal.beside.$arm\n", _DOWN)]},
    ),
    Injection(
        "no_rotation", _PANDA, {_TOUCH: [("posture ◁ orient ◁ approach", "posture ◁ approach")]}
    ),
    Injection(
        "no_rotation",
        _SIDE,
        {
            _SIDE: [
                ("◁ turn ◁ between", "◁ between"),
                ("approach ◁ turn ◁ aloft", "approach ◁ aloft"),
                ("approach at rest and turn at rest", "approach at rest"),
            ]
        },
    ),
    Injection(
        "wrong_object",
        _GRASP,
        {
            _TABLE: [
                ("contexts:\n", f"{_BLOCK}\ncontexts:\n{_BESIDE}"),
                ("  cube: {things: [cube], place: *half_of_table, joints: *looking}\n", ""),
            ]
        },
    ),
    Injection(
        "wrong_order",
        _PANDA,
        {
            _PANDA: [
                ("  grasp: {then: hold}\n", ""),
                ("retreat: {then: succeed}", "retreat: {then: grasp}\n  grasp: {then: succeed}"),
                ("hold undefined: grasp", "hold undefined: end"),
            ]
        },
    ),
    Injection("never_seen", _PANDA, {_STAGE: [("color: [1, 0, 0]", "color: [0.5, 0.5, 0.5]")]}),
    Injection("lost", _PANDA, fault=Removal),
    Injection("occluded", _PANDA, fault=OneEye),
    Injection(
        "out_of_reach",
        _PANDA,
        {
            _STAGE: [
                ("size: [0.6 reach,", "size: [1.3 reach,"),
                ("position: [bench.x,", "position: [bench.x + 0.45 reach,"),
                ("x: [bench.x - 0.08 reach, bench.x + 0.08 reach]", "x: [86 cm, 90 cm]"),
            ]
        },
    ),
    Injection("held", _PANDA, {_TOUCH: [(_TOP, _BELOW)]}),
    Injection("no_action", _PANDA, {_TOUCH: [("  X10: reach ◁ touch\n", "")]}),
    Injection("time", _PANDA, {_PANDA: [("episode_time: 90 s", "episode_time: 3 s")]}),
    Injection("not_followed", _PANDA, fault=FrozenJoint),
    Injection("backend", _PANDA, fault=Halt),
    Injection("", _PANDA, {_TOUCH: [("rate: 5e-4, window: 0.5 s", "rate: 1e-15, window: 0.5 s")]}),
    Injection(
        "",
        _PANDA,
        {_STAGE: [("    things: [cube]\n", "    things: [cube]\n    dark_after: 1 s\n")]},
    ),
    Injection(
        "", _PANDA, {_STAGE: [("contexts:\n", "disturbance: {camera_position: 6 cm}\ncontexts:\n")]}
    ),
    Injection("", _PANDA, {_STAGE: [("mass: 100 g", "mass: 6 kg")]}),
    Injection("", _PANDA, fault=partial(Distortion, _scaled_loads(0.0))),
    Injection("", _PANDA, fault=partial(Distortion, _scaled_loads(0.1))),
    Injection("", _PANDA, fault=partial(Distortion, _drifting_loads)),
    Injection("", _PANDA, fault=partial(Distortion, _offset_joint)),
    Injection("", _PANDA, fault=partial(Distortion, _shifted_rows)),
    Injection("", _PANDA, fault=lambda backend: Distortion(StaleImages(), backend)),
)


class CauseVerdict(NamedTuple):
    """Verdict on the explanation of one episode.

    Attributes:
        kind: Injected kind.
        named: Kind of the named first cause; empty for "I do not know".
        failed: True if the episode failed; others have nothing to explain.
        late: Difference of the first tick from the injection, s; NaN without a time.
        sentence: Words of the named cause.
    """

    kind: str
    named: str
    failed: bool
    late: float
    sentence: str


def verdicts(
    injection: Injection, seeds: Sequence[int], backend: str, keep: Path | None = None
) -> Iterator[CauseVerdict]:
    """Run the episodes of an injection, and yield the verdicts on their explanations.

    Args:
        injection: Injected cause.
        seeds: Seeds of the episodes.
        backend: Name of the simulated backend.
        keep: Folder that keeps the recordings, if any.
    """
    with TemporaryDirectory() as folder:
        program = written(injection.edits, Path(folder), injection.program)
        on = {"robot": "panda"} if injection.program == _PANDA else {}
        request = cbdsl.load(program, stage=injection.stage or None, values=on)
        for seed in seeds:
            # A new backend for each episode: faults change it.
            with cbdsl.simulate(request, backend=backend, cameras="ideal") as world:
                robot = world.robot.backend
                assert isinstance(robot, SimulatedBackend)
                fault = injection.fault(robot) if injection.fault else None
                recording = Recording(request.program, request.robot, request.urdf)
                ended: list[EpisodeResult] = []
                observers = [recording, _End(ended), *([fault] if fault else [])]
                # An episode that cannot go on is recorded up to its error.
                with suppress(EpisodeError):
                    world.robot.runner().run(
                        request.stage, seed, observer=EpisodeObservers(*observers)
                    )
                target = Path(folder) if keep is None else keep / injection.kind
                file = recording.write(target, ended[0])
            yield _verdict(injection.kind, file, None if fault is None else fault.time)


class _End(EpisodeObserver):
    """Keeper of the result."""

    def __init__(self, ended: list[EpisodeResult]) -> None:
        self._ended = ended

    def note_end(self, result: EpisodeResult) -> None:
        self._ended.append(result)


def _verdict(kind: str, file: Path, time: float | None) -> CauseVerdict:
    history = History(read_recording(file))
    diagnosis = diagnose(history)
    cause = diagnosis.cause
    if cause is None:
        return CauseVerdict(kind, "", diagnosis.failed, np.nan, "; ".join(diagnosis.ruled_out))
    late = np.nan if time is None else float(history.time[cause.tick]) - time
    return CauseVerdict(kind, cause.kind, diagnosis.failed, late, cause.sentence)


def written(edits: Edits, folder: Path, program: str) -> str | Path:
    """Write the edited documents to a folder, and return the program to run."""
    library = Library()
    for name, replacements in edits.items():
        kind = StageDocument if library.find(StageDocument, name) else ProgramDocument
        text = library.text(library.locate(kind, name))
        for before, after in replacements:
            if text.count(before) < 1:
                raise ValueError(f"{name}: '{before.strip()}' is not in its text")
            text = text.replace(before, after, 1)
        (folder / f"{name}.yaml").write_text(text, "utf-8")
    if not edits:
        return program
    # Documents beside a program are found before others of the same name.
    target = folder / f"{program}.yaml"
    if not target.exists():
        target.write_text(library.text(library.locate(ProgramDocument, program)), "utf-8")
    return target


def table(results: Sequence[CauseVerdict]) -> str:
    """Return the right first causes by kind as a table in Markdown, with exact intervals."""
    lines = ["| injected | failed | first cause right | within 0.2 s | named instead |"]
    lines.append("| --- | --- | --- | --- | --- |")
    groups: dict[str, list[CauseVerdict]] = defaultdict(list)
    for result in results:
        # An injection that made no episode fail has a row, too.
        groups[result.kind] += [result] if result.failed else []
    for kind, group in groups.items():
        right = [each for each in group if each.named == kind]
        timed = [each for each in right if not np.isnan(each.late)]
        near = sum(abs(each.late) <= _NEAR for each in timed)
        other = Counter(each.named or "I do not know" for each in group if each.named != kind)
        names = ", ".join(f"{name} {count}" for name, count in other.items())
        title = kind or "not on the list"
        when = f"{near} of {len(timed)}" if timed else ""
        lines.append(
            f"| {title} | {len(group)} | {len(right)} of {len(group)} | {when} | {names} |"
        )
    for name, kinds in (
        ("all on the list", [kind for kind in groups if kind]),
        ("published", [kind for kind in PUBLISHED if kind in groups]),
    ):
        own = [each for kind in kinds for each in groups[kind]]
        if own:
            hits = sum(each.named == each.kind for each in own)
            low, high = exact_interval(hits, len(own))
            share = f"{hits} of {len(own)} ({100 * low:.0f} to {100 * high:.0f} %)"
            lines.append(f"| {name}, {len(kinds)} kinds | {len(own)} | {share} | | |")
    return "\n".join(lines)


def main() -> None:
    """Run the injections of one set, and print verdicts and table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", choices=("developed", "judged"), default="judged")
    parser.add_argument("--seeds", type=int, default=2, help="Episodes of each injection.")
    parser.add_argument("--first", type=int, default=900, help="First seed.")
    parser.add_argument("--kinds", default="", help="Kinds, parted by commas, and unlisted [all].")
    parser.add_argument("--backend", default="mujoco")
    parser.add_argument("--keep", type=Path, help="Folder that keeps the recordings.")
    options = parser.parse_args()
    chosen = DEVELOPED if options.set == "developed" else JUDGED
    results = []
    for injection in chosen:
        if options.kinds and (injection.kind or "unlisted") not in options.kinds.split(","):
            continue
        seeds = range(options.first, options.first + options.seeds)
        for verdict in verdicts(injection, seeds, options.backend, options.keep):
            results.append(verdict)
            print(json.dumps(verdict._asdict()), flush=True)
    print(table(results))


if __name__ == "__main__":
    main()
