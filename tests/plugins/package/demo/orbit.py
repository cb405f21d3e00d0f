"""Modifier that moves a position around its reference, on a horizontal circle."""

import math
from collections.abc import Mapping

import numpy as np

from cbdsl.extend.modifier import Floats, ModifierType

ORBIT = ModifierType(
    name="orbit",
    summary="a level circle around the reference",
    accepts=frozenset({"position"}),
    options={"radius": "length", "period": "time"},
    implementation="demo.orbit:orbit",
)


def orbit(reference: Floats, feedback: Floats, time: float, options: Mapping[str, float]) -> Floats:
    """Return the point of the circle at a time."""
    angle = 2.0 * math.pi * time / options["period"]
    turned = np.array([math.cos(angle), math.sin(angle), 0.0])
    return reference + options["radius"] * turned
