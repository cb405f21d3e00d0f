"""Built-in modifiers: their keys and files."""

from __future__ import annotations

from dataclasses import fields

import pytest

from cbdsl.documents.program import ControllerSection
from cbdsl.program.controller import Controller
from cbdsl.types.modifier import MODIFIERS
from cbdsl.types.resource_type import TYPES


@pytest.mark.parametrize("name", MODIFIERS.builtins)
def test_built_in_modifier_is_a_key_of_controllers_and_has_a_file(name: str) -> None:
    kind = MODIFIERS.get(name)
    assert name in ControllerSection.model_fields
    assert name in {field.name for field in fields(Controller)}
    assert kind.slot == f"cbdsl.runtime.modifiers.{name}:bind"
    assert kind.purpose or kind.accepts == frozenset(TYPES)
