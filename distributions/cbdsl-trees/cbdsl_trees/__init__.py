"""Programs as behaviours of py_trees."""

from cbdsl_trees.behaviour import STATUS, ProgramBehaviour

__all__ = ["STATUS", "ProgramBehaviour"]
