"""All judges, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cbdsl_reproduction.judges import (
    both_hands,
    calibration,
    catalogs,
    claims,
    constellations,
    ensure_stacked,
    everyday,
    find_by_touch,
    find_the_other,
    five_skills,
    force,
    gripper,
    guarded,
    handover,
    holding,
    hover_follow,
    impedance,
    insertion,
    mounted_touch,
    pick_and_place,
    placing,
    planned_stacks,
    reach,
    relations,
    robosuite,
    scenes,
    schemas,
    served,
    stacks,
    success_rates,
    touch_table,
    triangulation,
)
from cbdsl_reproduction.judges.judge import Judge

_ALL = (
    success_rates.JUDGE,
    catalogs.JUDGE,
    claims.JUDGE,
    everyday.JUDGE,
    holding.JUDGE,
    placing.JUDGE,
    pick_and_place.JUDGE,
    gripper.JUDGE,
    both_hands.JUDGE,
    handover.JUDGE,
    find_the_other.JUDGE,
    find_by_touch.JUDGE,
    touch_table.JUDGE,
    hover_follow.JUDGE,
    insertion.JUDGE,
    stacks.JUDGE,
    planned_stacks.JUDGE,
    ensure_stacked.JUDGE,
    force.JUDGE,
    impedance.JUDGE,
    constellations.JUDGE,
    scenes.JUDGE,
    triangulation.JUDGE,
    calibration.JUDGE,
    schemas.JUDGE,
    reach.JUDGE,
    five_skills.JUDGE,
    mounted_touch.JUDGE,
    relations.JUDGE,
    served.JUDGE,
    guarded.JUDGE,
    robosuite.JUDGE,
)

#: Judges in the order of ``cb judge --list``.
JUDGES: Mapping[str, Judge] = MappingProxyType({judge.name: judge for judge in _ALL})
