"""Judge of ``cb why``: episodes with injected causes, and the first causes that it names.

``python benchmarks/first_causes.py --seeds 20`` runs the judged programs. Explanations were
developed with ``--set developed``, which has other programs. Injections act through programs,
stages, and the simulated backend; ``cb why`` reads recordings alone.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from injected_causes import DEVELOPED, JUDGED, Edits, Injection

import cbdsl
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


class CauseVerdict(NamedTuple):
    """Verdict on the explanation of one episode.

    Attributes:
        kind: Injected kind; empty for a cause that is not on the list.
        name: Name of such a cause; else the kind.
        named: Kind of the named first cause; empty for "I do not know".
        failed: True if the episode failed; others have nothing to explain.
        late: Difference of the first tick from the injection, s; NaN without a time.
        sentence: Words of the named cause, or of the reasons why none is named.
        seconds: Time that the explanation took, s.
    """

    kind: str
    name: str
    named: str
    failed: bool
    late: float
    sentence: str
    seconds: float


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
        on = {"robot": "panda"} if injection.program == "pick" else {}
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
                target = Path(folder) if keep is None else keep / injection.title
                file = recording.write(target, ended[0])
            yield explained(injection, file, None if fault is None else fault.time)


class _End(EpisodeObserver):
    """Keeper of the result."""

    def __init__(self, ended: list[EpisodeResult]) -> None:
        self._ended = ended

    def note_end(self, result: EpisodeResult) -> None:
        self._ended.append(result)


def explained(injection: Injection, file: Path, begin: float | None) -> CauseVerdict:
    """Return the verdict on the explanation of a recording, whose fault began at a time, s."""
    started = time.perf_counter()
    history = History(read_recording(file))
    diagnosis = diagnose(history)
    seconds = time.perf_counter() - started
    cause, late = diagnosis.cause, np.nan
    if cause is not None and begin is not None:
        late = float(history.time[cause.tick]) - begin
    reasons = "; ".join((*diagnosis.doubts, *diagnosis.ruled_out))
    named, sentence = ("", reasons) if cause is None else (cause.kind, cause.sentence)
    title = injection.title
    return CauseVerdict(injection.kind, title, named, diagnosis.failed, late, sentence, seconds)


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
    print(f"at most {max((each.seconds for each in results), default=0.0):.1f} s an episode")


if __name__ == "__main__":
    main()
