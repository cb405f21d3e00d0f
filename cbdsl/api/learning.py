"""Learning algorithms and their data, for learners of other packages and for analyses.

``ACCOMMODATE`` is Algorithm 1 of the source, ``ASSIMILATE`` Algorithm 2, ``EXPLORE`` Algorithm 3.
"""

from __future__ import annotations

from cbdsl.learning.accommodate import Accommodate, TransitionCounts
from cbdsl.learning.allocation_tree import TriedContext
from cbdsl.learning.assimilate import Assimilate, AssimilateConstants
from cbdsl.learning.catalogs.action_outcome import NOOP, ActionOutcome
from cbdsl.learning.catalogs.catalog_exploration import CatalogConstants
from cbdsl.learning.catalogs.exploration import ExplorationStep
from cbdsl.learning.catalogs.exploration_constants import ExplorationConstants
from cbdsl.learning.catalogs.stack_plan import StackPlan, pairs_of, plan_stack, plan_stacks
from cbdsl.learning.catalogs.thing_graph import support_graph
from cbdsl.learning.constants import AccommodateConstants, Form
from cbdsl.learning.decisions import Decisions
from cbdsl.learning.experience import Experience
from cbdsl.learning.impedance import ImpedanceProfile, ImpedanceTest
from cbdsl.learning.learner import ASSIMILATE
from cbdsl.numeric.affordance_model import AffordanceModel
from cbdsl.program.catalog_models import pair_models
from cbdsl.training.impedance_gauge import ImpedanceGauge
from cbdsl.types.direction import DIRECTIONS

__all__ = [
    "ASSIMILATE", "DIRECTIONS", "NOOP", "Accommodate", "AccommodateConstants",
    "ActionOutcome", "AffordanceModel", "Assimilate", "AssimilateConstants",
    "CatalogConstants", "Decisions", "Experience", "ExplorationConstants", "ExplorationStep",
    "Form", "ImpedanceGauge", "ImpedanceProfile", "ImpedanceTest", "StackPlan",
    "TransitionCounts", "TriedContext", "pair_models", "pairs_of", "plan_stack", "plan_stacks",
    "support_graph",
]  # fmt: skip
