"""CB35n: stage documents."""

from __future__ import annotations

from cbdsl.errors.codes.example import stage
from cbdsl.errors.entry import Entry

_PATH = "programs/stages/example.yaml"

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
)
