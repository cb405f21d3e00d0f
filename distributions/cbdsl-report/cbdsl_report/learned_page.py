"""Page of learned policies: curves over trials, and each trial's policy and densities."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from itertools import zip_longest
from typing import Any

import numpy as np

from cbdsl.api.documents import Provenance
from cbdsl.api.drawing import (
    LETTERS,
    Decision,
    PolicyTransitions,
    decisions,
    percent,
    policy_graph,
    policy_transitions,
    svg,
)
from cbdsl.extend.command import Bundle, count, filled
from cbdsl_report.density_svg import SHOWN, density_svgs
from cbdsl_report.interquartile import Band
from cbdsl_report.landscape import Landscape
from cbdsl_report.learned_files import InternalModel, Learned
from cbdsl_report.markup import ASSETS, Markup, html, letters, table, terms
from cbdsl_report.trial_groups import Measured, TrialGroup, measured, trial_groups

_STYLES = ("vendor/uPlot.min.css", "page.css", ASSETS / "learned.css")
_SCRIPTS = ("vendor/uPlot.iife.min.js", "page.js", "data.js", "chart.js", ASSETS / "learned.js")
#: Number of episodes at the beginning and the end that are compared.
_SOME = 10


def learned_page(learned: Sequence[Learned], above: float) -> str:
    """Return the page of one or more policies; the same files give the same text.

    Args:
        learned: Learned policies, at least one.
        above: Threshold for drawn arcs: only larger shares are drawn, in [0, 1].
    """
    groups = trial_groups(learned)
    results = [measured(group) for group in groups]
    programs = list(dict.fromkeys(each.policy.program for each in learned))
    slots = {
        "heading": escape(", ".join(programs)),
        "where": escape(_where(groups)),
        "verdict": escape(_verdict(learned)),
        "groups": _summary(results),
        "contexts": _contexts(groups),
        "choice": _choice(learned),
        "trials": "\n".join(_trial(each, place, above) for place, each in enumerate(learned)),
    }
    title, data = f"{', '.join(programs)}, learned", _data(results, learned)
    return filled(ASSETS / "learned.html", title, _STYLES, _SCRIPTS, data, slots)


def _where(groups: Sequence[TrialGroup]) -> str:
    trials = sum(len(group.trials) for group in groups)
    stages = dict.fromkeys(
        trial.policy.provenance.stage.name
        for group in groups
        for trial in group.trials
        if trial.policy.provenance is not None
    )
    episodes = sum(len(trial.curve.reward) for group in groups for trial in group.trials)
    fields = f"{count(trials, 'trial')}, {count(episodes, 'episode')}"
    return f"{fields} on {', '.join(stages)}" if stages else fields


def _verdict(learned: Sequence[Learned]) -> str:
    rewards = [reward for each in learned for reward in each.curve.reward]
    return f"{percent(sum(reward > 0 for reward in rewards) / len(rewards))} rewarded"


def _summary(results: Sequence[Measured]) -> str:
    """Return a table with the results of each group."""
    rows = [
        (
            each.group.name,
            len(each.group.trials),
            each.group.episodes,
            percent(each.group.hits().mean()),
            # At this place, the window holds exactly the first episodes.
            _interval(each.rate[_SOME], min(_SOME, each.group.episodes) - 1),
            _interval(each.rate[_SOME], -1),
        )
        for each in results
    ]
    some = f"{_SOME} episodes"
    headings = ("learning task", "trials", "episodes", "rewarded", f"first {some}", f"last {some}")
    caption = "Reward per transition: interquartile mean over trials, and its 95 % interval"
    if all(len(each.group.trials) == 1 for each in results):
        caption = "Reward per transition, on average"
    return table(caption, headings, rows)


def _interval(band: Band, place: int) -> str:
    middle, lower, upper = (f"{values[place]:.3f}" for values in band)
    return middle if lower == upper else f"{middle} [{lower}, {upper}]"


def _contexts(groups: Sequence[TrialGroup]) -> str:
    rows = []
    for group in groups:
        episodes = [
            row
            for curve in (trial.curve for trial in group.trials)
            for row in zip(curve.context, curve.reward, curve.transitions, strict=True)
        ]
        for context in sorted({context for context, _, _ in episodes}):
            own = [(reward, many) for name, reward, many in episodes if name == context]
            hits = sum(reward > 0 for reward, _ in own)
            rate = float(np.mean([reward / many for reward, many in own]))
            steps = float(np.median([many for _, many in own]))
            rows.append((group.name, context, len(own), hits, percent(hits / len(own)),
                         f"{rate:.3f}", f"{steps:g}"))  # fmt: skip
    headings = ("learning task", "context", "episodes", "rewarded", "success rate",
                "reward per transition", "transitions, median")  # fmt: skip
    return table("By the stage's contexts", headings, rows, words=(0, 1))


def _choice(learned: Sequence[Learned]) -> str:
    """Return the menu of trials, if there are several."""
    if len(learned) == 1:
        return ""
    options = "".join(
        f'<option value="trial-{place}">{escape(each.policy.name)}</option>'
        for place, each in enumerate(learned)
    )
    return f'<label>Trial <select id="trial">{options}</select></label>'


def _trial(learned: Learned, place: int, above: float) -> str:
    """Return the section of one trial."""
    policy = learned.policy
    diagram = svg(policy_graph(_transitions(learned, above)))
    densities = "".join(map(_density, learned.models))
    notes = "".join(f"<p>{html(note)}</p>" for note in learned.notes)
    name = escape(policy.name)
    return (
        f'<section class="trial" id="trial-{place}" aria-label="{name}"><h2>{name}</h2>{notes}'
        f'<div class="pair"><figure class="scroll" tabindex="0" aria-label="Transition diagram">'
        f"{diagram}<figcaption>What the policy does, and what follows.</figcaption></figure>"
        f"<div>{_policy(learned)}{densities}</div></div>"
        f'<details class="episodes"><summary>Episodes</summary><div class="rows" tabindex="0" '
        f'role="region" aria-label="Episodes"></div></details>'
        f"<details><summary>Provenance</summary>{_provenance(learned)}</details></section>"
    )


def _transitions(learned: Learned, above: float) -> PolicyTransitions:
    """Return the policy's graph, with rewarded states from the journal, if there is one."""
    ends = [(each.end, each.reward > 0) for each in learned.experiences]
    # One unrewarded episode suffices: a final state counts as rewarded only without exception.
    unrewarded = {end for end, rewarded in ends if not rewarded}
    known = {end for end, _ in ends}
    return policy_transitions(
        learned.policy, above, False, learned.programs, known - unrewarded if known else None
    )


def _policy(learned: Learned) -> str:
    """Return the policy as a table."""
    rows = [_row(learned, decision) for decision in decisions(learned.policy)]
    headings = ("state", "action", "Q", "next best", "tried", "met", "ended", "what follows")
    caption = f"Policy; a state has a letter for {', '.join(learned.policy.predicates)}"
    return table(caption, headings, rows, words=(0, 1, 3, 7))


def _row(learned: Learned, decision: Decision) -> tuple[object, ...]:
    meanings = [
        f"{member} {LETTERS[letter].meaning}"
        for member, letter in zip(learned.policy.predicates, decision.state, strict=True)
    ]
    values = learned.policy.values.get(decision.state, {})
    others = {action: value for action, value in values.items() if action != decision.action}
    next_best = max(others, key=lambda action: others[action]) if others else None
    shares = Counter({state: decision.share(state) for state in decision.after})
    follows = ", ".join(f"{state} {percent(share)}" for state, share in shares.most_common(3))
    return (
        letters(decision.state, meanings),
        decision.action,
        None if decision.value is None else f"{decision.value:.3f}",
        None if next_best is None else f"{next_best} {others[next_best]:.3f}",
        decision.tried or None,
        decision.met,
        decision.ended or None,
        follows,
    )


def _density(model: InternalModel) -> str:
    """Return an internal model as pictures and numbers."""
    density = model.document.density
    samples = np.array([density.mean] if density.form == "gaussian" else density.samples)
    spread = density.deviation if density.form == "gaussian" else samples.std(axis=0)
    likeliest, _ = Landscape(model).peak()
    rows = [
        (f"{joint.name}, {SHOWN[joint.unit][1]}",
         *(f"{SHOWN[joint.unit][0] * v:.1f}" for v in
           (joint.lower, joint.upper, likeliest[place], samples[:, place].mean(), spread[place])))
        for place, joint in enumerate(model.joints)
    ]  # fmt: skip
    headings = ("joint", "lower limit", "upper limit", "likeliest", "mean", "deviation")
    kind = (
        "a Gaussian for each joint"
        if density.form == "gaussian"
        else f"kernels around {count(len(samples), 'configuration')}"
    )
    use = "" if model.name is None else f", from which the program draws {model.name}"
    fields = (
        f"Where {model.document.effector} was rewarded{use}: {kind}, {percent(density.uniform)} "
        "uniform. Densities are relative to a uniform one."
    )
    pictures = "".join(density_svgs(model))
    numbers = table(f"Internal model {model.document.name}", headings, rows)
    return (
        f'<figure class="densities"><figcaption>{html(fields)}</figcaption>'
        f'<div class="scroll" tabindex="0" role="region" aria-label="Densities">{pictures}</div>'
        f"{numbers}</figure>"
    )


def _provenance(learned: Learned) -> str:
    """Return the provenance of the policy, which allows it to be learned again."""
    provenance = learned.policy.provenance
    fields: dict[str, object] = {"file": learned.file.name, "sha256": _digest(learned.sha256)}
    if provenance is not None:
        fields = dict(_origin(provenance)) | fields
    return terms(fields)


def _origin(provenance: Provenance) -> Iterator[tuple[str, object]]:
    yield "command", Markup(f"<code>{escape(provenance.command)}</code>")
    for role in ("program", "robot", "stage"):
        identity = getattr(provenance, role)
        yield role, Markup(f"{escape(identity.name)} {_digest(identity.sha256)}")
    yield "parameters", _pairs(provenance.parameters) or "none"
    yield "actions", ", ".join(provenance.actions)
    yield "seed, trial", f"{provenance.seed}, {provenance.trial}"
    yield "backend", f"{provenance.backend}, images by {provenance.renderer}"
    yield provenance.algorithm, _pairs(provenance.constants)
    yield "versions", _pairs(provenance.versions)


def _pairs(fields: Mapping[str, object]) -> str:
    return ", ".join(f"{name} {value}" for name, value in fields.items())


def _digest(sha256: str) -> Markup:
    return Markup(f'<code class="digest">{escape(sha256)}</code>')


def _data(results: Sequence[Measured], learned: Sequence[Learned]) -> str:
    bundle = Bundle()
    header: dict[str, Any] = {
        "groups": [_curves(each, bundle) for each in results],
        "trials": [
            {
                "again": _again(each),
                "episodes": list(_episodes(each)),
            }
            for each in learned
        ],
    }
    return bundle.text(header)


def _episodes(learned: Learned) -> Iterator[dict[str, Any]]:
    """Yield the rows of the table of episodes, with parts of the journal, if there is one."""
    curve = learned.curve.model_dump(mode="json")
    unknown = dict.fromkeys(("seed", "sim_seconds", "rewarding", "end"))
    for row, experience in zip_longest(zip(*curve.values(), strict=True), learned.experiences):
        known = (
            unknown
            if experience is None
            else {
                "seed": experience.seed,
                "sim_seconds": experience.sim_seconds,
                "rewarding": experience.rewarding,
                "end": experience.end,
            }
        )
        yield {**dict(zip(curve, row, strict=True)), **known}


def _again(learned: Learned) -> str:
    """Return the command that runs the program in the world of an episode."""
    words = ["cb", "run", learned.policy.program]
    provenance = learned.policy.provenance
    if provenance is not None:
        words += ["--stage", provenance.stage.name, "--backend", provenance.backend]
    return shlex.join([*words, "--seed", "SEED"])


def _curves(measured: Measured, bundle: Bundle) -> dict[str, Any]:
    def kept(band: Band) -> dict[str, object]:
        return {part: bundle.add(each.astype(np.float32)) for part, each in band._asdict().items()}

    return {
        "name": measured.group.name,
        "trials": len(measured.group.trials),
        "rate": {str(window): kept(band) for window, band in measured.rate.items()},
        "hits": {str(window): kept(band) for window, band in measured.hits.items()},
    }
