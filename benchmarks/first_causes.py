"""Judge of ``cb why``: episodes with injected causes, and the first causes that it names.

``python benchmarks/first_causes.py --seeds 20`` runs the judged programs. Explanations were
developed with ``--set developed``, which has other programs. Injections act through programs,
stages, and the simulated backend; ``cb why`` reads recordings alone. ``--keep`` and ``--explain``
record the episodes once, and explain them by later rules. ``--failed 20`` records each kind until
it has 20 failed episodes whose program succeeds without the fault.
"""

from __future__ import annotations

import argparse
import json
import re
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from developed_causes import DEVELOPED
from injected_causes import Edits, Injection
from judged_causes import JUDGED

import cbdsl
from cbdsl.backends.backend import BackendError
from cbdsl.backends.simulated_backend import SimulatedBackend
from cbdsl.documents.program import ProgramDocument
from cbdsl.documents.stage import StageDocument
from cbdsl.numeric.proportion import exact_interval
from cbdsl.reporting.recorded import read_recording
from cbdsl.runtime.episode import EpisodeError
from cbdsl.runtime.episode_observer import EpisodeObserver, EpisodeObservers
from cbdsl.runtime.episode_result import EpisodeResult
from cbdsl.runtime.recording import Recording
from cbdsl.yaml_text.library import Library
from cbdsl_why.diagnosis import diagnose
from cbdsl_why.history import History

#: The seven kinds of FailGen (AHA, arXiv 2410.00371).
PUBLISHED = (
    "no_grasp", "slip", "translation", "rotation", "no_rotation", "wrong_order", "wrong_object",
)  # fmt: skip
# Difference of the first tick from the injection that counts as right, s.
_NEAR = 0.2
# Time of an episode of most programs, s.
_TIME = 90.0
# File that lists the kept recordings, one JSON array a line.
_INDEX = "recordings.jsonl"
# File that lists all attempts to record failed episodes, one JSON array a line.
_ATTEMPTS = "attempts.jsonl"
# Use of a program in the text of another.
_USED = re.compile(r"program: (\w+)[,}\n]")


class CauseVerdict(NamedTuple):
    """Verdict on the explanation of one episode.

    Attributes:
        kind: Injected kind; empty for a cause that is not on the list.
        name: Name of such a cause; else the kind.
        named: Kind of the named first cause; empty for "I do not know".
        failed: True if the episode failed; others have nothing to explain.
        late: Difference of the first tick from the injection, s; NaN without a time.
        sentence: Words of the named cause, or of the reasons why none is named.
        seconds: CPU time that the explanation took, s.
    """

    kind: str
    name: str
    named: str
    failed: bool
    late: float
    sentence: str
    seconds: float


class RecordedInjection(NamedTuple):
    """Recorded episode of an injection.

    Attributes:
        place: Index of the injection in its set.
        begin: Time from which the fault acted, s; ``None`` without a time.
        file: JSON file of the recording.
    """

    place: int
    begin: float | None
    file: Path


def recorded(
    chosen: Sequence[Injection], index: int, seed: int, options: argparse.Namespace, keep: Path
) -> RecordedInjection:
    """Record an episode of an injection, and list it in the folder's index.

    Args:
        chosen: Injections of the set.
        index: Index of the injection in the set.
        seed: Seed of the episode.
        options: Options of the command: backend, and time of an episode.
        keep: Folder of the recordings.
    """
    row, _ = attempt(chosen, index, seed, options, keep)
    enlist(row, keep)
    return row


def enlist(row: RecordedInjection, keep: Path) -> None:
    """Add a recording to the index of its folder."""
    with (keep / _INDEX).open("a") as rows:
        print(json.dumps((row.place, row.begin, str(row.file))), file=rows)


def attempt(
    chosen: Sequence[Injection], index: int, seed: int, options: argparse.Namespace, keep: Path
) -> tuple[RecordedInjection, bool]:
    """Record an episode of an injection, and return whether it succeeded, too.

    Args:
        chosen: Injections of the set.
        index: Index of the injection in the set.
        seed: Seed of the episode.
        options: Options of the command: backend, and time of an episode.
        keep: Folder of the recordings.
    """
    injection = chosen[index]
    edits = tuple((name, tuple(changes)) for name, changes in injection.edits.items())
    request = requested(
        injection.program, edits, injection.stage, on_robot(injection), options.time
    )
    # A new backend for each episode: faults change it.
    with cbdsl.simulate(request, backend=options.backend, cameras="ideal") as world:
        robot = world.robot.backend
        assert isinstance(robot, SimulatedBackend)
        fault = injection.fault(robot) if injection.fault else None
        recording = Recording(request.program, request.robot, request.urdf)
        ended: list[EpisodeResult] = []
        observers = [recording, _End(ended), *([fault] if fault else [])]
        # An episode that cannot go on is recorded up to its error.
        with suppress(EpisodeError, BackendError):
            world.robot.runner().run(request.stage, seed, observer=EpisodeObservers(*observers))
        # Some injections have the same kind: a folder of its own parts their seeds.
        file = recording.write(keep / f"{index}_{injection.title}", ended[0])
    begin = None if fault is None else fault.time
    return RecordedInjection(index, begin, file.relative_to(keep)), ended[0].succeeded


@cache
def requested(
    program: str,
    edits: tuple[tuple[str, tuple[tuple[str, str], ...]], ...],
    stage: str,
    robot: str | None,
    limit: float,
) -> cbdsl.RunRequest:
    """Return the checked request to run a program with edited documents.

    Args:
        program: Name of the program.
        edits: Replacements by name of the document.
        stage: Name of the stage; empty for the program's.
        robot: Name of the robot; ``None`` for the first one that fits.
        limit: Time of an episode, s.
    """
    with TemporaryDirectory() as folder:
        path = written(dict(edits), Path(folder), program, limit)
        return cbdsl.load(path, stage=stage or None, robot=robot)


def is_sound(injection: Injection, seed: int, options: argparse.Namespace) -> bool:
    """Return whether the program succeeds without the fault, on its own stage."""
    request = requested(injection.program, (), "", on_robot(injection), options.time)
    ended: list[EpisodeResult] = []
    with cbdsl.simulate(request, backend=options.backend, cameras="ideal") as world:
        world.robot.runner().run(request.stage, seed, observer=_End(ended))
    return ended[0].succeeded


def record_failures(
    chosen: Sequence[Injection], indices: Sequence[int], options: argparse.Namespace, keep: Path
) -> None:
    """Record failed episodes until each kind has the requested number, and list these.

    Kinds take turns, and so do the injections of a kind. An episode counts if it fails, and the
    program without the fault succeeds with the same seed. A file lists all attempts, so that a
    later call continues.

    Args:
        chosen: Injections of the set.
        indices: Indices of the recorded injections.
        options: Options of the command.
        keep: Folder of the recordings.
    """
    attempts = attempted(keep)
    sound: dict[tuple[str, str, int], bool] = {}
    groups: dict[str, list[int]] = defaultdict(list)
    for index in indices:
        groups[chosen[index].title].append(index)
    for offset in range(10 * options.failed):
        for group in groups.values():
            index, seed = group[offset % len(group)], options.first + offset
            failed = sum(row[0] in group and row[2] == "failed" for row in attempts)
            if failed >= options.failed or any(row[:2] == (index, seed) for row in attempts):
                continue
            one = chosen[index]
            key = (one.program, one.robot, seed)
            if key not in sound:
                sound[key] = is_sound(one, seed, options)
            outcome = "unsound"
            if sound[key]:
                row, succeeded = attempt(chosen, index, seed, options, keep)
                outcome = "succeeded" if succeeded else "failed"
                if succeeded:
                    (keep / row.file).unlink()
                else:
                    enlist(row, keep)
            attempts.append((index, seed, outcome))
            with (keep / _ATTEMPTS).open("a") as rows:
                print(json.dumps(attempts[-1]), file=rows)


def attempted(keep: Path) -> list[tuple[int, int, str]]:
    """Return index, seed and outcome of all attempts of a folder."""
    file = keep / _ATTEMPTS
    lines = file.read_text().splitlines() if file.exists() else []
    return [(index, seed, outcome) for index, seed, outcome in map(json.loads, lines)]


def attempt_table(chosen: Sequence[Injection], keep: Path) -> str:
    """Return the numbers of failed and dropped episodes by injection as a table in Markdown."""
    counts: dict[int, Counter[str]] = defaultdict(Counter)
    for index, _, outcome in attempted(keep):
        counts[index][outcome] += 1
    lines = ["| injected | program | robot | failed | succeeded | unsound |"]
    lines.append("| --- | --- | --- | --- | --- | --- |")
    for index, of in sorted(counts.items()):
        one = chosen[index]
        numbers = " | ".join(str(of[name]) for name in ("failed", "succeeded", "unsound"))
        lines.append(f"| {one.title} | {one.program} | {one.robot or 'dexter'} | {numbers} |")
    return "\n".join(lines)


def on_robot(injection: Injection) -> str | None:
    """Return the name of the robot of an injection; ``None`` for the first one that fits."""
    return injection.robot or ("panda" if injection.program == "pick" else None)


class _End(EpisodeObserver):
    """Keeper of the result."""

    def __init__(self, ended: list[EpisodeResult]) -> None:
        self._ended = ended

    def note_end(self, result: EpisodeResult) -> None:
        self._ended.append(result)


def explained(injection: Injection, file: Path, begin: float | None) -> CauseVerdict:
    """Return the verdict on the explanation of a recording, whose fault began at a time, s."""
    started = time.process_time()
    history = History(read_recording(file))
    diagnosis = diagnose(history)
    seconds = time.process_time() - started
    cause, late = diagnosis.cause, np.nan
    if cause is not None and begin is not None:
        late = float(history.time[cause.tick]) - begin
    reasons = "; ".join((*diagnosis.doubts, *diagnosis.ruled_out))
    named, sentence = ("", reasons) if cause is None else (cause.kind, cause.sentence)
    title = injection.title
    return CauseVerdict(injection.kind, title, named, diagnosis.failed, late, sentence, seconds)


def written(edits: Edits, folder: Path, program: str, limit: float = _TIME) -> str | Path:
    """Write the edited documents to a folder, and return the program to run.

    Args:
        edits: Replacements by name of the document.
        folder: Folder of the written documents.
        program: Name of the program.
        limit: Time of an episode in place of 90 s, s.
    """
    library = Library()
    for name, replacements in edits.items():
        kind = StageDocument if library.find(StageDocument, name) else ProgramDocument
        text = library.text(library.locate(kind, name))
        for before, after in replacements:
            if text.count(before) < 1:
                raise ValueError(f"{name}: '{before.strip()}' is not in its text")
            text = text.replace(before, after, 1)
        (folder / f"{name}.yaml").write_text(text, "utf-8")
    if not edits and limit == _TIME:
        return program
    # Documents beside a program are found before others of the same name.
    target = folder / f"{program}.yaml"
    if not target.exists():
        target.write_text(library.text(library.locate(ProgramDocument, program)), "utf-8")
    text = target.read_text("utf-8")
    if limit != _TIME and "episode_time:" not in text:
        text = text.replace("\nlimits: {", "\nlimits: {episode_time: 90 s, ")
    target.write_text(text.replace("episode_time: 90 s", f"episode_time: {limit:g} s"), "utf-8")
    _write_used(library, target)
    return target


def _write_used(library: Library, user: Path) -> None:
    """Write the programs that a program uses beside it.

    A used program would otherwise use the shipped document in place of an edited one.
    """
    for name in _USED.findall(user.read_text("utf-8")):
        file = user.with_name(f"{name}.yaml")
        if not file.exists():
            file.write_text(library.text(library.locate(ProgramDocument, name)), "utf-8")
        _write_used(library, file)


def table(results: Sequence[CauseVerdict]) -> str:
    """Return the right first causes by kind as a table in Markdown, with exact intervals."""
    lines = ["| injected | failed | first cause right | within 0.2 s | named instead |"]
    lines.append("| --- | --- | --- | --- | --- |")
    rows: dict[tuple[str, str], list[CauseVerdict]] = defaultdict(list)
    for result in results:
        # An injection that made no episode fail has a row, too.
        rows[result.kind, result.name] += [result] if result.failed else []
    for (kind, title), group in rows.items():
        right = [each for each in group if each.named == kind]
        timed = [each for each in right if not np.isnan(each.late)]
        near = sum(abs(each.late) <= _NEAR for each in timed)
        other = Counter(each.named or "I do not know" for each in group if each.named != kind)
        names = ", ".join(f"{name} {count}" for name, count in other.items())
        when = f"{near} of {len(timed)}" if timed else ""
        lines.append(
            f"| {title} | {len(group)} | {len(right)} of {len(group)} | {when} | {names} |"
        )
    for name, part in (
        ("not on the list", {key: group for key, group in rows.items() if not key[0]}),
        ("on the list", {key: group for key, group in rows.items() if key[0]}),
        ("published", {key: group for key, group in rows.items() if key[0] in PUBLISHED}),
    ):
        own = [each for group in part.values() for each in group]
        if own:
            hits = sum(each.named == each.kind for each in own)
            low, high = exact_interval(hits, len(own))
            share = f"{hits} of {len(own)} ({100 * low:.0f} to {100 * high:.0f} %)"
            lines.append(f"| {name}, {len(part)} kinds | {len(own)} | {share} | | |")
    return "\n".join(lines)


def main() -> None:
    """Run the injections of one set, and print verdicts and table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", choices=("developed", "judged"), default="judged")
    parser.add_argument("--seeds", type=int, default=2, help="Episodes of each injection.")
    parser.add_argument("--first", type=int, default=900, help="First seed.")
    parser.add_argument("--kinds", default="", help="Kinds, parted by commas, or unlisted [all].")
    parser.add_argument("--backend", default="mujoco")
    parser.add_argument("--time", type=float, default=_TIME, help="Time of an episode, s.")
    parser.add_argument("--keep", type=Path, help="Folder that keeps the recordings.")
    parser.add_argument("--explain", type=Path, help="Folder of kept recordings: run none.")
    parser.add_argument("--failed", type=int, help="Failed episodes of each kind to record.")
    parser.add_argument("--quiet", action="store_true", help="Record, and explain nothing.")
    options = parser.parse_args()
    chosen = DEVELOPED if options.set == "developed" else JUDGED
    kinds = options.kinds.split(",") if options.kinds else []
    own = [n for n, e in enumerate(chosen) if not kinds or (e.kind or "unlisted") in kinds]
    results = []
    with TemporaryDirectory() as temporary:
        keep = options.explain or options.keep or Path(temporary)
        keep.mkdir(parents=True, exist_ok=True)
        if options.failed:
            record_failures(chosen, own, options, keep)
            print(attempt_table(chosen, keep))
            return
        seeds = range(options.first, options.first + options.seeds)
        rows: Iterable[RecordedInjection] = (
            kept(keep, own)
            if options.explain
            else (recorded(chosen, n, seed, options, keep) for seed in seeds for n in own)
        )
        for row in rows:
            if not options.quiet:
                results.append(explained(chosen[row.place], keep / row.file, row.begin))
                print(json.dumps(results[-1]._asdict()), flush=True)
    print(table(results))
    print(f"at most {max((each.seconds for each in results), default=0.0):.1f} CPU s an episode")


def kept(keep: Path, indices: Sequence[int]) -> Iterator[RecordedInjection]:
    """Yield the kept recordings of some injections of a set."""
    for line in (keep / _INDEX).read_text().splitlines():
        index, begin, file = json.loads(line)
        if index in indices:
            yield RecordedInjection(index, begin, Path(file))


if __name__ == "__main__":
    main()
