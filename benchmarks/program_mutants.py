"""Judge of the checks of steps: random edits of shipped programs, found before motion or not.

``python -m benchmarks.program_mutants --count 300`` compares findings of ``cb validate`` with a
search that is written here and shares nothing with the checker. ``--seeds 5 --only NAME`` runs
mutants without physics and counts failures in all seeds.
"""

from __future__ import annotations

import argparse
import copy
import itertools
import random
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import cbdsl
from cbdsl.checking.safety_net import check_safely
from cbdsl.checking.session import Session
from cbdsl.diagnostics.errors import DiagnosticsError
from cbdsl.diagnostics.legible_text import encoded
from cbdsl.numeric.proportion import exact_interval
from cbdsl.runtime.episode import EpisodeError
from cbdsl.yaml_text.composer import compose
from cbdsl.yaml_text.library import Library, shipped
from cbdsl.yaml_text.writer import dump_plain

PROGRAMS = shipped() / "programs"
_ENDS = {"succeed", "fail", "end"}
_LETTERS = {
    "undefined": "-", "failed": "-", "moving": "0", "running": "0", "false": "0",
    "at rest": "1s", "arrived": "1", "stuck": "s", "succeeded": "1", "true": "1",
}  # fmt: skip
_PART = re.compile(rf"(.+?)\s+(not\s+)?({'|'.join(_LETTERS)})$")


class Mutant(NamedTuple):
    """Edited program.

    Attributes:
        program: Name of the program.
        edit: Kind of the edit and its place.
        document: Edited document, as plain data.
    """

    program: str
    edit: str
    document: dict[str, Any]


def programs_with_steps() -> dict[str, dict[str, Any]]:
    """Return the shipped programs that state steps, as plain data by name."""
    texts = {file.stem: file.read_text("utf-8") for file in sorted(PROGRAMS.glob("*.yaml"))}
    plain = {name: compose(text, name).root.plain() for name, text in texts.items()}
    return {
        name: data for name, data in plain.items() if isinstance(data, dict) and "steps" in data
    }


def mutants(count: int, seed: int = 0, only: str = "") -> Iterator[Mutant]:
    """Yield random edits of programs: each kind in turn, where a program has a place for it."""
    rng, programs = random.Random(seed), programs_with_steps()
    names = [name for name in programs if only in ("", name)]
    kinds = itertools.cycle(
        (_delete_exit, _swap_target, _swap_exits, _invert_bound, _drop_requires)
    )
    made = 0
    while made < count:
        name, edit = rng.choice(names), next(kinds)
        document = copy.deepcopy(programs[name])
        place = edit(document, rng)
        if place is not None:
            made += 1
            yield Mutant(name, f"{edit.__name__.strip('_')} {place}", document)


def _exits(document: Mapping[str, Any]) -> list[tuple[str, dict[str, Any], str]]:
    """Return the step, container and key of each target."""
    places: list[tuple[str, dict[str, Any], str]] = []
    for name, step in document["steps"].items():
        places += [(name, step, key) for key in ("then", "failed") if key in step]
        places += [(name, each, key) for each in step.get("exits", ()) for key in each]
    return places


def _delete_exit(document: dict[str, Any], rng: random.Random) -> str | None:
    name, container, key = rng.choice(_exits(document))
    del container[key]
    step = document["steps"][name]
    step["exits"] = [each for each in step.get("exits", ()) if each]
    if not step["exits"]:
        del step["exits"]
    return f"{name}: {key}"


def _swap_target(document: dict[str, Any], rng: random.Random) -> str | None:
    name, container, key = rng.choice(_exits(document))
    others = [
        to for to in (*document["steps"], "succeed", "fail") if to != container[key].split()[0]
    ]
    container[key] = rng.choice(others)
    return f"{name}: {key} -> {container[key]}"


def _swap_exits(document: dict[str, Any], rng: random.Random) -> str | None:
    several = [(n, s) for n, s in document["steps"].items() if len(s.get("exits", ())) > 1]
    if not several:
        return None
    name, step = rng.choice(several)
    place = rng.randrange(len(step["exits"]) - 1)
    step["exits"][place : place + 2] = step["exits"][place : place + 2][::-1]
    return f"{name}: {place}"


def _invert_bound(document: dict[str, Any], rng: random.Random) -> str | None:
    if not document.get("conditions"):
        return None
    name = rng.choice(list(document["conditions"]))
    turned = {"<": ">", ">": "<"}
    text = document["conditions"][name]
    document["conditions"][name] = re.sub("[<>]", lambda sign: turned[sign[0]], text)
    return str(name)


def _drop_requires(document: dict[str, Any], rng: random.Random) -> str | None:
    own = [n for n, c in document["controllers"].items() if isinstance(c, dict) and "requires" in c]
    if not own:
        return None
    name = rng.choice(own)
    del document["controllers"][name]["requires"]
    return str(name)


def findings(mutant: Mutant) -> list[str]:
    """Return the codes of errors and warnings of a mutant, as ``cb validate`` reports them."""
    file = PROGRAMS / f"{mutant.program}.yaml"
    library = Library(given={file: encoded(dump_plain(mutant.document))})
    found = check_safely(file, Session(library))
    return [each.code for each in found if each.severity.value != "note"]


# The search enumerates all letters of a step's members, even letters that a member never has. It
# therefore allows more paths than the checker, so that each of its faults is certain.
class Search:
    """Search of a program's steps over all values of their members.

    Args:
        document: Program as plain data.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self._document = document
        self._steps: dict[str, Any] = document["steps"]

    def faults(self) -> list[str]:
        """Return its faults: unreached steps, untaken exits, and steps without a way out."""
        taken: dict[tuple[str, int], bool] = {}
        next_: dict[str, set[str]] = {}
        for name in self._steps:
            rules, next_[name] = self._rules(name), {name}
            taken |= {(name, place): False for place in range(len(rules))}
            members = self._members(name)
            for values in itertools.product(*(self._values(each) for each in members)):
                letters = dict(zip(members, values, strict=True))
                for place, (holds, to) in enumerate(rules):
                    if any(all(letters[m] in own for m, own in way) for way in holds):
                        taken[name, place] = True
                        next_[name].add(to)
                        break
        reached, waiting = set[str](), [self._document.get("start") or next(iter(self._steps))]
        while waiting:
            name = waiting.pop()
            if name in self._steps and name not in reached:
                reached.add(name)
                waiting += next_[name]
        faults = [f"{name} is never reached" for name in self._steps if name not in reached]
        faults += [f"exit {place} of {name} is never taken"
                   for (name, place), is_taken in taken.items() if name in reached and not is_taken
                   and place < len(self._steps[name].get("exits", ()))]  # fmt: skip
        limits = self._document.get("limits", {})
        ends = {name for name in reached if not next_[name] <= self._steps.keys()}
        if ends and limits.get("reward_ends") is False and "episode_time" not in limits:
            while more := {n for n in reached - ends if next_[n] & ends}:
                ends |= more
            faults += [f"{name} has no way out" for name in reached - ends]
        return faults

    def _members(self, name: str) -> list[str]:
        own = [each.strip() for each in self._steps[name].get("do", name).split("◁")]
        texts = " ".join(key for each in self._steps[name].get("exits", ()) for key in each)
        return own + [
            c for c in self._document.get("conditions", {}) if re.search(rf"\b{c}\b", texts)
        ]

    def _values(self, member: str) -> str:
        is_controller = member not in {
            **self._document.get("conditions", {}),
            **self._document.get("use", {}),
        }
        return "-01s" if is_controller else "-01"

    def _rules(self, name: str) -> list[tuple[list[list[tuple[str, str]]], str]]:
        step, conditions = self._steps[name], self._document.get("conditions", {})
        own = [member for member in self._members(name) if member not in conditions]
        rules = [
            ([self._way(way) for way in re.split(r"\bor\b", when)], to.split()[0])
            for each in step.get("exits", ())
            for when, to in each.items()
        ]
        if "failed" in step:
            rules.append(([[(member, "-")] for member in own], step["failed"].split()[0]))
        if "then" in step:
            rules.append(([[(member, "1") for member in own]], step["then"].split()[0]))
            rules.append(([[(member, "1s") for member in own]], "fail"))
        return rules

    def _way(self, text: str) -> list[tuple[str, str]]:
        parts = []
        for part in (each.strip() for each in re.split(r"\band\b", text)):
            if part == "otherwise":
                continue
            match = _PART.match(part)
            if match:
                letters = _LETTERS[match[3]]
                if match[2]:
                    letters = "".join(each for each in "-01s" if each not in letters)
                parts.append((match[1], letters))
            else:
                is_not = part.startswith("not ")
                parts.append((part.removeprefix("not ").strip(), "0" if is_not else "1"))
        return parts


def fails(mutant: Mutant, seeds: int, folder: Path) -> bool:
    """Return whether a mutant succeeds in no seed without physics."""
    file = folder / f"{mutant.program}.yaml"
    file.write_text(dump_plain(mutant.document), "utf-8")
    for seed in range(seeds):
        with suppress(DiagnosticsError, EpisodeError):
            if cbdsl.run(file, seed=seed, backend="kinematic")[0].succeeded:
                return False
    return True


def main() -> None:
    """Print the mutants that each way finds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="")
    parser.add_argument("--seeds", type=int, default=0)
    options = parser.parse_args()
    faulty, missed, failing, before = 0, [], 0, 0
    for mutant in mutants(options.count, options.seed, options.only):
        codes, faults = findings(mutant), Search(mutant.document).faults()
        faulty += bool(faults)
        missed += [(mutant.program, mutant.edit, faults)] if faults and not codes else []
        if options.seeds and fails(mutant, options.seeds, Path("build")):
            failing, before = failing + 1, before + bool(codes)
            print(
                f"fails: {mutant.program}, {mutant.edit}: {', '.join(codes) or 'no finding'}",
                flush=True,
            )
    print(
        f"{faulty} of {options.count} faulty by the search, of which {len(missed)} have no finding"
    )
    for each in missed:
        print(*each)
    if failing:
        low, high = exact_interval(before, failing)
        print(f"{before} of {failing} failing ones found before motion ({low:.0%} to {high:.0%})")


if __name__ == "__main__":
    main()
