"""Programs correspond by the abstract structure of their actions, and never by their names."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.controller import Composition
from cbdsl.program.correspondence import affordances, correspondence, in_place_of
from tests.conftest import Checked


def test_two_hands_stand_in_for_one(checked: Checked) -> None:
    one, both = checked("reachtouch"), checked("reachtouch_bimanual")
    assert affordances(one) == affordances(both) == {"force"}
    names = correspondence(one, both)
    assert names == {"searchtrack": "searchtrack", "reach": "reach", "touch": "touch"}
    instead = in_place_of(one, both, names)
    assert (instead.name, instead.members) == ("reachtouch", one.members)
    assert [each.name for each in instead.actions] == [each.name for each in one.actions]
    assert instead.primitives["touch"].lead.feedback.name == "hands.net_forces"


def test_substitute_keeps_its_own_priorities(checked: Checked) -> None:
    one, both = checked("reachtouch"), checked("reachtouch_bimanual")
    names = correspondence(one, both)
    assert names is not None
    assert set(both.policy.values()) == {"searchtrack", "reach ◁ touch"}
    orders = {each.name: str(each.composition) for each in in_place_of(one, both, names).actions}
    # Arms that press below the reach that holds them apart never touch anything.
    assert orders["touch ◁ reach"] == orders["reach ◁ touch"] == "reach ◁ touch"
    assert orders["reach"] == "reach"
    turned = both._replace(policy=both.policy | {"X10": "touch ◁ reach"})
    orders = {each.name: str(each.composition) for each in in_place_of(one, turned, names).actions}
    assert orders["touch ◁ reach"] == "touch ◁ reach"


def test_names_and_order_do_not_matter(checked: Checked) -> None:
    one, both = checked("reachtouch"), checked("reachtouch_bimanual")
    other = {"searchtrack": "look", "reach": "enclose", "touch": "squeeze"}
    renamed = _renamed(both, other)
    names = correspondence(one, renamed)
    assert names == {"look": "searchtrack", "enclose": "reach", "squeeze": "touch"}
    instead = in_place_of(one, renamed, names)
    assert instead.members == ("searchtrack", "reach", "touch")
    assert {str(each.composition) for each in instead.actions if each.composition} == {
        each.name for each in one.actions if each.composition
    }


def _renamed(program: CheckedProgram, other: Mapping[str, str]) -> CheckedProgram:
    """Return the same program with other names, in another order."""
    actions = []
    for action in reversed(program.actions):
        parts = action.composition.primitives if action.composition else ()
        composition = Composition(tuple(p._replace(name=other[p.name]) for p in parts))
        actions.append(
            action._replace(name=str(composition), composition=composition)
            if parts
            else action._replace(name=other[action.name])
        )
    return program._replace(
        members=tuple(reversed([other[name] for name in program.members])),
        primitives={other[n]: p._replace(name=other[n]) for n, p in program.primitives.items()},
        actions=tuple(actions),
    )


@pytest.mark.parametrize("name", ["tactileprobe", "bimanualtouch", "searchtrack"])
def test_program_with_other_actions_has_no_correspondence(checked: Checked, name: str) -> None:
    assert correspondence(checked("reachtouch"), checked(name)) is None
