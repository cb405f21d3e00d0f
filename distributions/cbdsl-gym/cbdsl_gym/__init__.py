"""Programs as environments of Gymnasium; importing it registers ``cbdsl/Program-v0``."""

import gymnasium

from cbdsl_gym.environment import LETTERS, ProgramEnvironment

#: Name for ``gymnasium.make``, after the name of this package.
ID = "cbdsl/Program-v0"

__all__ = ["ID", "LETTERS", "ProgramEnvironment"]

# Gymnasium finds the package by the name before the colon, and this name in its registry.
gymnasium.register(ID, entry_point="cbdsl_gym.environment:ProgramEnvironment")
