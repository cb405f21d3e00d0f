"""Series of trials of the source's Chapters 4 and 7, as data."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, replace

from cbdsl.api.learning import Form
from cbdsl.api.program import Action, CheckedProgram


@dataclass(frozen=True)
class Series:
    """Trials that learn one program from zero, on one stage.

    Attributes:
        name: Name of the files of its trials.
        label: Label in tables and pictures.
        program: Program whose actions are learned.
        stage: Training stage.
        episodes: Number of episodes of each trial, as in the source.
        trials: Number of trials, as in the source.
        sequential: True if the compositions are excluded from the actions.
        density: Form of the internal models.
        hopeless: Contexts of the stage without possible reward.
    """

    name: str
    label: str
    program: str
    stage: str
    episodes: int
    trials: int
    sequential: bool = False
    density: Form = "kernel"
    hopeless: frozenset[str] = frozenset()

    @property
    def short(self) -> str:
        """Label without the program, for pictures of a single program."""
        return self.label.partition(", ")[2] or self.label

    def actions(self, program: CheckedProgram) -> tuple[Action, ...]:
        """Return the actions to choose from."""
        return program.sequential_actions if self.sequential else program.actions

    def command(
        self, seed: int, trials: int, episodes: int, backend: str, cameras: str | None = None
    ) -> str:
        """Return the command line of ``cb learn`` for the same trials."""
        words = ["cb", "learn", self.program, "--out", f"{self.name}.yaml", "--stage", self.stage]
        words += ["--episodes", str(episodes), "--seed", str(seed), "--backend", backend]
        words += ["--cameras", cameras] if cameras is not None else []
        words += ["--trials", str(trials)] if trials > 1 else []
        words += ["--sequential"] if self.sequential else []
        words += ["--density", self.density] if self.density != "kernel" else []
        return shlex.join(words)


#: Section 4.2.1 with co-articulation, and without.
COARTICULATED = Series(
    name="searchtrack_coarticulated",
    label="SEARCHTRACK, co-articulated",
    program="searchtrack",
    stage="searchtrack_training",
    episodes=50,
    trials=10,
)
SEQUENTIAL = replace(
    COARTICULATED,
    name="searchtrack_sequential",
    label="SEARCHTRACK, sequential",
    sequential=True,
)
#: Section 4.2.2.
TACTILEPROBE = Series(
    name="tactileprobe",
    label="TACTILEPROBE",
    program="tactileprobe",
    stage="held_right",
    episodes=25,
    trials=1,
    density="gaussian",
)
#: Section 4.3.1.
REACHTOUCH = Series(
    name="reachtouch",
    label="REACHTOUCH",
    program="reachtouch",
    stage="reachtouch_training",
    episodes=25,
    trials=1,
    hopeless=frozenset({"absent"}),
)
#: Section 4.3.2. The source has 25 episodes in the text, and 50 in the caption of its figure.
VISUALINSPECT = Series(
    name="visualinspect",
    label="VISUALINSPECT",
    program="visualinspect",
    stage="visualinspect_training",
    episodes=50,
    trials=1,
)
#: Section 4.3.3.
BIMANUALTOUCH = Series(
    name="bimanualtouch",
    label="BIMANUALTOUCH",
    program="bimanualtouch",
    stage="bimanualtouch_training",
    episodes=25,
    trials=1,
)
#: Section 7.1.1.
PICKANDPLACE = Series(
    name="pick_and_place",
    label="PICKANDPLACE",
    program="pick_and_place",
    stage="things_and_a_pad",
    episodes=30,
    trials=10,
)
