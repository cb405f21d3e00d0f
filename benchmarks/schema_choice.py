"""How long a schema takes to choose: 5 features, 30 allocations, trees of 256 leaves each.

python benchmarks/schema_choice.py [--choices 5000] [--json]
"""

from __future__ import annotations

import argparse
import json
import random
import time
from collections.abc import Callable
from typing import Any

from cbdsl.checking.assimilation import program_to_assimilate
from cbdsl.checking.session import Session
from cbdsl.documents.policy import PolicyDocument
from cbdsl.documents.program import ProgramDocument
from cbdsl.program.checked import Action, CheckedProgram
from cbdsl.runtime.policies.schema_policy import SchemaPolicy
from cbdsl.types.decision_tree import Leaf, Split, Tree
from cbdsl.yaml_text.library import Library

NAMES = tuple(f"allocation_{number}" for number in range(30))
FEATURES = tuple(f"feature_{number}" for number in range(5))
DEPTH = 8


def tree(depth: int, leaf: Callable[[], Any], rng: random.Random) -> Tree[Any]:
    """Return a full tree of random questions."""
    if not depth:
        return Leaf(leaf())
    parts = (tree(depth - 1, leaf, rng) for _ in range(2))
    return Split(rng.choice(FEATURES), rng.random(), *parts)


def large_schema() -> CheckedProgram:
    """Return REACHTOUCH as a schema that has as many allocations and features."""
    library, rng = Library(), random.Random(1)
    policy = library.read(library.locate(PolicyDocument, "reachtouch"), PolicyDocument)
    path = library.locate(ProgramDocument, "reachtouch")
    program = program_to_assimilate(path, policy, Session(library), {})
    assert program.schema is not None
    abstract = dict.fromkeys(each.abstract for each in program.actions if each.allocation)
    actions = [each for each in program.actions if not each.allocation]
    actions += [
        Action(f"{name} with {allocation}", abstract=name, allocation=allocation)
        for name in abstract
        for allocation in NAMES
    ]
    schema = program.schema._replace(
        allocations={name: {} for name in NAMES},
        choice=tree(DEPTH, lambda: (rng.choice(NAMES),), rng),
        reward=tree(DEPTH, lambda: 0.9, rng),
        otherwise=NAMES,
    )
    return program._replace(actions=tuple(actions), schema=schema)


def main() -> None:
    """Choose, and print the median and the 99th percentile."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--choices", type=int, default=5000)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    policy, rng, seconds = SchemaPolicy(large_schema()), random.Random(2), []
    for _ in range(options.choices):
        features = {name: rng.random() for name in FEATURES}
        policy.begin()
        began = time.perf_counter()
        policy.choose("X0-", changed=True, features=features)
        seconds.append(time.perf_counter() - began)
    seconds.sort()
    row = {
        "median_us": round(1e6 * seconds[len(seconds) // 2], 1),
        "p99_us": round(1e6 * seconds[len(seconds) * 99 // 100], 1),
    }
    print(json.dumps(row) if options.json else row)


if __name__ == "__main__":
    main()
