"""CB52n: the fields of harmonic potentials."""

from __future__ import annotations

from cbdsl.errors.codes.example import controller
from cbdsl.errors.entry import Entry

_MOVE = "feedback: right_arm.position, effector: right_arm"
_GOAL = "reference: [50 cm, -20 cm, 0 cm], " + _MOVE
_BOUNDS = "lower: [20 cm, -60 cm, -40 cm], upper: [80 cm, 20 cm, 20 cm]"
_GRID = f"{_BOUNDS}, spacing: 2 cm"
_BOX = "{lower: [45 cm, -40 cm, -40 cm], upper: [55 cm, -30 cm, 0 cm]}"


def _harmonic(field: str, rest: str = _GOAL) -> str:
    return controller(f"potential: harmonic, {rest}, field: {{{field}}}")


_GOOD = _harmonic(f"{_GRID}, obstacles: [stereo.motion, {_BOX}]")

FIELDS = (
    Entry(
        "CB520",
        "no field",
        "the potential '{potential}' needs a field",
        "A harmonic function is solved for on a grid: its `field` gives the corners of the "
        "workspace, the spacing of the grid, and the obstacles.",
        controller(f"potential: harmonic, {_GOAL}"),
        good=_GOOD,
    ),
    Entry(
        "CB521",
        "setting that means nothing for this potential",
        "the potential '{potential}' has no {setting}",
        "Only a harmonic function has a `field`: a grid and obstacles to go round. It has no "
        "`funnel`, because it comes to its goal along a path of its own.",
        controller(f"potential: spring, {_GOAL}, field: {{{_GRID}}}"),
        good=controller(f"potential: spring, {_GOAL}"),
    ),
    Entry(
        "CB522",
        "obstacle of another type",
        "the obstacle '{name}' is {kind}, the feedback '{feedback}' is {feedback_type}",
        "What a motion keeps away from has a place in the same space: a position for a position, "
        "a configuration of the same joints for a configuration.",
        _harmonic(f"{_GRID}, obstacles: [cyclopean.motion]"),
        good=_GOOD,
    ),
    Entry(
        "CB523",
        "obstacle without a size",
        "'{name}' has no size that could be seen",
        "Only what is triangulated has a radius of its own. For anything else, such as the tip of "
        "another arm, say `{center: left_arm.position, radius: 12 cm}`.",
        _harmonic(f"{_GRID}, obstacles: [left_arm.position]"),
        good=_harmonic(f"{_GRID}, obstacles: [{{center: left_arm.position, radius: 12 cm}}]"),
    ),
    Entry(
        "CB524",
        "corner that does not fit",
        "{problem}",
        "Corners have one number per component of the feedback. Only a field over the very joints "
        "that are moved can do without: it then lies between their limits.",
        _harmonic("lower: [20 cm, -60 cm], upper: [80 cm, 20 cm, 20 cm], spacing: 2 cm"),
        good=_GOOD,
    ),
    Entry(
        "CB525",
        "workspace or box without an inside",
        "{problem}",
        "Upper corners lie above lower ones, and a workspace is at least two cells of its grid "
        "wide along every axis.",
        _harmonic(f"{_BOUNDS}, spacing: 50 cm"),
        good=_GOOD,
    ),
    Entry(
        "CB526",
        "grid too fine",
        "a grid of {vertices} vertices takes too much memory and time",
        "The cost is proportional to the number of vertices, which may be as large as 160 cubed. A "
        "spacing of a third of the narrowest passage is fine enough.",
        _harmonic(f"{_BOUNDS}, spacing: 1 mm"),
        good=_GOOD,
    ),
    Entry(
        "CB527",
        "goal outside the workspace",
        "the reference lies outside the workspace along axis {axis}",
        "A harmonic function leads to goals within its own border only.",
        _harmonic(_GRID, "reference: [50 cm, -20 cm, 30 cm], " + _MOVE),
        good=_GOOD,
    ),
    Entry(
        "CB528",
        "goal inside an obstacle",
        "the reference lies in {name}, or nearer to it than the clearance",
        "Nothing that keeps away from an obstacle gets there.",
        _harmonic(
            f"{_GRID}, clearance: 5 cm, obstacles: [{_BOX}]",
            "reference: [50 cm, -35 cm, 4 cm], " + _MOVE,
        ),
        good=_GOOD,
    ),
    Entry(
        "CB529",
        "too many dimensions",
        "'{name}' has {size}, a field has three at the most",
        "The number of vertices grows with the power of the dimensions. Move the position of a "
        "tip instead, and let other controllers use the joints that are left.",
        _harmonic("spacing: 10 deg", "reference: 0, feedback: right_arm, effector: right_arm"),
        good=_harmonic("spacing: 2 deg", "reference: 0, feedback: head, effector: head"),
    ),
)
