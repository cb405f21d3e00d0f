"""Command ``cb tally``: count the rewarded episodes of a program."""

from typing import Annotated

import typer

import cbdsl

Program = Annotated[str, typer.Argument(help="Name or file of a program.")]
Episodes = Annotated[int, typer.Option("--episodes", min=1, help="Number of episodes.")]
BackendName = Annotated[str, typer.Option("--backend", help="Name of the backend.")]


def tally(program: Program, episodes: Episodes = 10, backend: BackendName = "kinematic") -> None:
    """Count the rewarded episodes of a program."""
    results = cbdsl.run(program, episodes=episodes, backend=backend)
    print(f"{sum(result.rewarded for result in results)} of {episodes} episodes are rewarded")
