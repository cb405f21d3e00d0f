"""Whether shipped relations name the contact of pairs whose sizes no training stage has.

The context follows from the seed, so that each one has its share. A pair that was not brought
together, or not tested in all directions, counts as not named.
The stage's relation sets how deep the object goes, on the other one or into it, since no signal
decides this. The name follows from the impedance alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack

from cbdsl_reproduction.judges.judge import Aim, BodyChoice, EpisodeVerdict, Judge, JudgedCondition

STAGE, PROGRAM = "pairs_of_other_sizes", "impedance"
# An object comes to rest on another one before it is lowered by the first distance; by the second
# one it goes 5 cm deep into another one.
_ON, _INTO = {"depth": "14 cm"}, {"depth": "8 cm"}
_VALUES: Mapping[str, Mapping[str, str]] = {
    "plane_on_plane": _ON,
    "spherical": _ON,
    "cylindrical": _INTO,
    "prismatic": _INTO,
}


def _measure(
    condition: JudgedCondition, body: BodyChoice, seeds: Sequence[int]
) -> Iterator[EpisodeVerdict]:
    """Yield the verdict on each pair."""
    from cbdsl.api.reading.relations import read_namer
    from cbdsl_reproduction.impedance_measurement import measure_impedance
    from cbdsl_reproduction.simulation_fixture import simulation_fixture

    name_of = read_namer(condition.name)
    with ExitStack() as stack:
        fixtures = {
            values["depth"]: stack.enter_context(
                simulation_fixture(PROGRAM, values, STAGE, body.backend, body.cameras)
            )
            for values in (_ON, _INTO)
        }
        runners = {depth: fixture.runner() for depth, fixture in fixtures.items()}
        contexts = fixtures[_ON["depth"]].stage.contexts
        for seed in seeds:
            context = list(contexts)[seed % len(contexts)]
            relation = contexts[context].relation or ""
            depth = _VALUES[relation]["depth"]
            measured = measure_impedance(fixtures[depth], runners[depth], seed, context)
            named = name_of(measured.profile) if measured.profile.is_whole else None
            outcomes = {"named right": named == relation} | {
                f"{each} named right": (named == relation if each == relation else None)
                for each in _VALUES
            }
            ending = f"named {named}; {measured.result.ending}"
            yield EpisodeVerdict(
                seed, outcomes, measured.result.sim_seconds, ending, context=context
            )


_AIMS = {"named right": Aim(0.9)} | {f"{each} named right": Aim(0.8) for each in _VALUES}

JUDGE = Judge(
    "relations",
    "names of the contact of two objects by its impedance",
    (JudgedCondition("contacts", PROGRAM, _AIMS, STAGE),),
    _measure,
    BodyChoice("mujoco", "ideal"),
    episodes=63,
    knowledge=("relations/contacts.yaml",),
)
