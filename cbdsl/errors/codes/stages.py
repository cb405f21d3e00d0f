"""CB35n: stage documents."""

from __future__ import annotations

from cbdsl.errors.codes.example import stage
from cbdsl.errors.entry import Entry

_PATH = "programs/stages/example.yaml"

_TABLE = (
    "fixtures:\n  table:\n    form: {shape: box, size: [60 cm, 60 cm, 4 cm]}\n"
    "    position: [50 cm, 0 cm, 0 cm]\n"
)


def _on_table(place: str, thing: str = "ball") -> str:
    context = f"  always: {{things: [{thing}], place: {{on: table{place}}}}}\n{_TABLE}"
    return stage(context).replace("  ball:", f"  {thing}:")


def _removed(after: str) -> str:
    deeds = f"released_after: 2 s, removed_after: {after}"
    return stage(f"  always: {{things: [ball], place: {{z: 0, held: true}}, {deeds}}}\n")


STAGES = (
    Entry(
        "CB351",
        "unknown thing, fixture, effector or joint",
        "'{name}' is no {what}",
        "A context names things and fixtures of its own stage, and effectors and joints of the "
        "stage's robot.",
        stage("  always: {things: [bal], place: {z: 0}}\n"),
        _PATH,
        good=stage("  always: {things: [ball], place: {z: 0}}\n"),
    ),
    Entry(
        "CB352",
        "span that ends before it begins",
        "this span goes from {first} down to {last}",
        "A span is written with its lower end first.",
        stage("  always: {things: [ball], place: {x: [3 cm, 1 cm], z: 0}}\n"),
        _PATH,
        good=stage("  always: {things: [ball], place: {x: [1 cm, 3 cm], z: 0}}\n"),
    ),
    Entry(
        "CB353",
        "setting that lacks another",
        "{problem}",
        "Things need a `place`, and where nothing is shown there is no place, no motion and "
        "nothing to remove. Only what is `held` can be released.",
        stage("  always: {things: [ball]}\n"),
        _PATH,
        good=stage("  always: {things: [ball], place: {z: 0}}\n"),
    ),
    Entry(
        "CB354",
        "fixture and thing of the same name",
        "'{name}' is a fixture of this stage already",
        "Fixtures and things are in one world, where each has a name of its own.",
        _on_table(", x: 50 cm", thing="table"),
        _PATH,
        good=_on_table(", x: 50 cm"),
    ),
    Entry(
        "CB355",
        "start outside the joint limits",
        "{angle} {unit} is outside the limits of joint '{joint}', {lower} to {upper} {unit}",
        "The robot cannot start there. Limits are those of the URDF model.",
        stage("  always: {joints: {tilt: 200 deg}, things: [ball], place: {z: 0}}\n"),
        _PATH,
        good=stage("  always: {joints: {tilt: 20 deg}, things: [ball], place: {z: 0}}\n"),
    ),
    Entry(
        "CB356",
        "place beside its fixture",
        "{axis} = {value} m is beside fixture '{name}', which goes from {first} to {last} m",
        "What is put on a fixture with its centre beside it falls.",
        _on_table(", x: [50 cm, 90 cm]"),
        _PATH,
        good=_on_table(", x: [50 cm, 60 cm]"),
    ),
    Entry(
        "CB357",
        "deeds that exclude each other",
        "this comes to nothing: {problem}",
        "A held thing moves only once it is let go of, and nothing happens to a thing that has "
        "been taken away.",
        _removed("1 s"),
        _PATH,
        good=_removed("3 s"),
    ),
)
