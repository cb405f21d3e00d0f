"""All experiments, in the order of the source."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cbdsl_reproduction.experiment import Experiment

# fmt: off
_ALL: tuple[Experiment, ...] = (
    Experiment("law-as-printed", "The control law taken literally", "Sections 3.1.3 and 3.3.2, Equations 3.18 to 3.26", "chapter_3.law_as_printed"),  # noqa: E501
    Experiment("fig-3.4", "Reaching alone, and with two conditioning potentials below", "Section 3.3.3.1, Figure 3.4", "chapter_3.fig_3_4"),  # noqa: E501
    Experiment("table-3.2", "Pixels per period, and localizability, at three depths", "Section 3.3.3.2, Table 3.2", "chapter_3.table_3_2"),  # noqa: E501
    Experiment("fig-3.5", "A box held in both hands and brought to where it is seen best", "Section 3.3.3.2, Figure 3.5", "chapter_3.fig_3_5"),  # noqa: E501
    Experiment("fig-3.6", "Barcodes read at three ranges", "Section 3.3.3.2, Figure 3.6", "chapter_3.fig_3_6"),  # noqa: E501
    Experiment("fig-4.4", "Where SEARCHTRACK's internal model expects something to track", "Section 4.2.1, Figure 4.4", "chapter_4.internal_models", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-4.5", "Transitions of SEARCHTRACK's policies, without co-articulation and with it", "Section 4.2.1, Figure 4.5", "chapter_4.transition_diagrams", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-4.6a", "How SEARCHTRACK is learned, without co-articulation and with it", "Section 4.2.1, Figure 4.6 (a)", "chapter_4.learning_curves", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-4.6b", "Earnings of SEARCHTRACK's policies without exploration", "Section 4.2.1, Figure 4.6 (b)", "chapter_4.greedy_reward", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-4.7", "Transitions of TACTILEPROBE's policy", "Section 4.2.2, Figure 4.7", "chapter_4.transition_diagrams", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-4.8", "Where TACTILEPROBE's internal models expect contact", "Section 4.2.2, Figure 4.8", "chapter_4.internal_models", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-4.10", "Transitions of REACHTOUCH's policy", "Section 4.3.1, Figure 4.10", "chapter_4.transition_diagrams", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-4.11", "Transitions of VISUALINSPECT's policy", "Section 4.3.2, Figure 4.11", "chapter_4.transition_diagrams", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-4.13", "Transitions of BIMANUALTOUCH's policy", "Section 4.3.3, Figure 4.13", "chapter_4.transition_diagrams", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-5.2", "Where motion is expected after something was shaken", "Section 5.2.1, Figure 5.2", "chapter_5.fig_5_2", keeps=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-5.3-5.5", "Where the channels of saturation, hue and intensity can be tracked in a room", "Section 5.2.1, Figures 5.3 to 5.5", "chapter_5.background_model", keeps=True),  # noqa: E501
    Experiment("fig-5.6", "Where touch is afforded", "Section 5.2.2, Figure 5.6", "chapter_5.touch_map", keeps=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-5.8", "Three ways to learn which arm to reach with", "Section 5.3.1.2, Figure 5.8", "chapter_5.three_learners", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-5.9", "Reaching again with other arms", "Section 5.3.1.2, Figure 5.9", "chapter_5.three_learners", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-5.10-5.11", "Which arm to reach with, and when not at all", "Section 5.3.1, Figures 5.10 and 5.11", "chapter_5.schema_trees", keeps=True),  # noqa: E501
    Experiment("fig-5.12", "TACTILEPROBE in the place of TOUCH", "Section 5.3.2, Figure 5.12", "chapter_5.fig_5_12", keeps=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-6.2", "Affordances of a green table", "Section 6.2.2, Figure 6.2", "chapter_6.catalogs", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-6.3", "Affordances of a small basketball", "Section 6.2.2, Figure 6.3", "chapter_6.catalogs", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-6.4", "Affordances of a red ball with two patches", "Section 6.2.2, Figure 6.4", "chapter_6.catalogs", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-6.5", "Three catalogs as icons", "Section 6.2.2, Figure 6.5", "chapter_6.catalogs", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-6.6", "A model-exploration program with a table", "Section 6.3.1, Figure 6.6", "chapter_6.model_programs", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-6.7", "A model-exploration program with three balls that are moved", "Section 6.3.1, Figure 6.7", "chapter_6.model_programs", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-6.8", "Novelty and surprise", "Section 6.3.1, Figure 6.8", "chapter_6.model_programs", learns=True, backend="kinematic"),  # noqa: E501
    Experiment("fig-7.2", "Transitions of PICKANDPLACE's policy", "Section 7.1.1, Figure 7.2", "chapter_4.transition_diagrams", learns=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-7.3", "Earnings of PICKANDPLACE while it is learned", "Section 7.1.1, Figure 7.3", "chapter_7.reward_curve", learns=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-7.4-7.6", "PICKANDPLACE with either hand, and from hand to hand", "Section 7.1.2, Figures 7.4 to 7.6", "chapter_7.hand_transfer", learns=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-7.7", "PICKANDPLACE joins the catalog of a green table", "Section 7.1.3, Figure 7.7", "chapter_7.grown_catalogs", learns=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-7.8", "PICKANDPLACE joins the catalog of a small basketball", "Section 7.1.3, Figure 7.8", "chapter_7.grown_catalogs", learns=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-7.9", "PICKANDPLACE joins the catalog of a red ball with two patches", "Section 7.1.3, Figure 7.9", "chapter_7.grown_catalogs", learns=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-7.10", "Two balls that can be placed on a table", "Section 7.1.3, Figure 7.10", "chapter_7.grown_catalogs", learns=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-7.13-7.14", "Loads on an object that is on or in another one", "Section 7.2, Figures 7.13 and 7.14", "chapter_7.fig_7_13", keeps=True, backend="mujoco"),  # noqa: E501
    Experiment("fig-7.16-7.17", "Affordances of three objects, and of stacks of them", "Section 7.3.2, Figures 7.16 and 7.17", "chapter_7.fig_7_17", keeps=True, backend="mujoco"),  # noqa: E501
    Experiment("table-7.1-7.2", "Which things stay on each other, of two and of three", "Section 7.3.2, Tables 7.1 and 7.2", "chapter_7.table_7_1", keeps=True, backend="mujoco"),  # noqa: E501
    Experiment("engines", "Shipped programs and policies on every engine", "Chapters 3 and 4, Sections 4.2 and 4.3", "engines", keeps=True),  # noqa: E501
)
# fmt: on

#: One line per experiment.
EXPERIMENTS: Mapping[str, Experiment] = MappingProxyType({each.name: each for each in _ALL})
