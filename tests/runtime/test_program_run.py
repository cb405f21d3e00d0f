"""Algorithm 1: states, transitions, rewards and budgets, on a synthetic world."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import groupby, pairwise

import numpy as np
import pytest

from cbdsl.program.checked import CheckedProgram
from cbdsl.program.transition import Transition
from cbdsl.runtime.policies.policy import Choice, Policy, WrittenPolicy
from cbdsl.runtime.tick import Tick
from cbdsl.types.resource import Origin
from tests.conftest import Checked
from tests.runtime.conftest import GRIP, TABLE_BALL, Play, Played, on_table
from tests.runtime.synthetic import Ball, World

# The head's joints among the actuated ones.
HEAD = slice(0, 2)

Written = Callable[..., CheckedProgram]

LOOK = "{potential: spring, reference: [0 deg, 0 deg], feedback: cyclopean.sat_10, effector: head}"
SEARCH = "{potential: spring, reference: head.uniform, feedback: head, effector: head}"
TURN = "{potential: spring, reference: [0 rad, 0.5 rad], feedback: head, effector: head}"
CLOSE = (
    "{potential: spring, reference: 2 N along normals, feedback: right_hand.finger_forces, "
    "effector: right_hand, seek: {until: 1 rad}}"
)


def nothing(rng: np.random.Generator) -> World:
    return World()


def programs(program: CheckedProgram) -> Iterator[CheckedProgram]:
    yield program
    for action in program.actions:
        if action.program is not None:
            yield from programs(action.program)


EPISODES = ["searchtrack", "tactileprobe", "reachtouch", "posture"]


@pytest.fixture(scope="module")
def played(checked: Checked, play: Play) -> Callable[[str], Played]:
    """Return a function that plays one episode of each shipped program, once."""
    found: dict[str, Played] = {}

    def of(name: str) -> Played:
        if name not in found:
            found[name] = play(checked(name), joints={"pan": 0.9})
        return found[name]

    return of


@pytest.mark.parametrize("name", EPISODES)
def test_transitions_form_a_chain_by_the_policy(
    checked: Checked, played: Callable[[str], Played], name: str
) -> None:
    program, episode = checked(name), played(name)
    top = episode.at(0)
    policy = WrittenPolicy(program.policy)
    assert top[0].state == "X" * len(program.members)
    assert [each.next_state for each in top[:-1]] == [each.state for each in top[1:]]
    assert [each.action for each in top] == [
        policy.choose(t.state, changed=True).action for t in top
    ]
    assert all(each.state != each.next_state for each in top)
    assert episode.result.predicates == (top[0].state, *(each.next_state for each in top))
    assert episode.result.actions == tuple(each.action for each in top)
    # The tick that ends an episode moves nothing any more.
    assert sum(each.ticks for each in top) == episode.result.ticks + 1
    times = [each.time for each in episode.transitions]
    assert times == sorted(times)


@pytest.mark.parametrize("name", EPISODES)
def test_rewards_are_the_environments_convergence_events(
    checked: Checked, played: Callable[[str], Played], name: str
) -> None:
    """Eq 4.2-4.4, counted anew from the transitions."""
    by_name = {program.name: program for program in programs(checked(name))}
    for each in played(name).transitions:
        program = by_name[each.program]
        events = [
            member
            for member, before, after in zip(
                program.members, each.state, each.next_state, strict=True
            )
            if before != "1" and after == "1"
        ]
        primitives = [program.primitives[event] for event in events if event in program.primitives]
        origins = [primitive.lead.feedback.origin for primitive in primitives]
        assert each.reward == origins.count(Origin.ENVIRONMENT)


@pytest.mark.parametrize("name", EPISODES)
def test_reward_ends_the_program_that_earns_it(played: Callable[[str], Played], name: str) -> None:
    episode = played(name)
    top = episode.at(0)
    assert [each.reward for each in top[:-1]] == [0] * (len(top) - 1)
    assert episode.result.rewarded == (top[-1].reward > 0)
    assert episode.result.rewarded == (name != "posture")


def test_used_program_reads_0_then_1_and_earns_its_user_nothing(
    played: Callable[[str], Played],
) -> None:
    episode = played("reachtouch")
    inner = [each for each in episode.at(1) if each.program == "searchtrack"]
    assert inner[-1].reward == 1
    outer = [(each.state, each.next_state, each.reward) for each in episode.at(0)]
    assert outer[:3] == [("XXX", "X--", 0), ("X--", "0XX", 0), ("0XX", "1XX", 0)]
    # Its letter is X again as soon as another action runs.
    assert outer[3][1][0] == "X"


@pytest.mark.parametrize("transitions", [1, 2, 3])
def test_used_program_that_gives_up_reads_undefined(
    written: Written, play: Play, transitions: int
) -> None:
    written(
        f"controllers: {{search: {SEARCH}, track: {LOOK}}}\nactions: [search, track, "
        'search <| track]\npolicy: {"**": search <| track}\n'
        f"limits: {{transitions: {transitions}}}\n",
        "seek",
    )
    user = written(
        f"use: {{seek: {{program: seek}}}}\ncontrollers: {{track: {LOOK}}}\n"
        "actions: [seek, track]\npolicy: {XX: seek, 0X: seek}\n"
    )
    episode = play(user, nothing)
    assert episode.at(0)[-1].next_state == "-X"
    assert f"seek used up its {transitions} transitions" in episode.result.ending
    assert len(episode.at(1)) == transitions
    assert not episode.result.rewarded


def test_used_program_that_ends_at_once_does_not_hang_its_user(
    written: Written, play: Play
) -> None:
    written(f"controllers: {{track: {LOOK}}}\nactions: [track]\npolicy: {{'1': track}}\n", "idle")
    user = written(
        f"use: {{idle: {{program: idle}}}}\ncontrollers: {{track: {LOOK}}}\n"
        "actions: [idle, track]\npolicy: {'**': idle}\n"
    )

    def stop(tick: Tick) -> None:
        assert tick.observation.time < 60, "it hangs"

    episode = play(user, nothing, watch=stop)
    assert [each.next_state for each in episode.at(0)] == ["-X", "-X"]
    assert "idle has no action for state X" in episode.result.ending


def test_transitions_of_an_episode_are_limited(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{search: {SEARCH}}}\nactions: [search]\npolicy: {{'*': search}}\n"
        "limits: {transitions: 3}\n"
    )
    episode = play(program, nothing)
    assert episode.result.predicates == ("X", "0", "1", "0")
    assert "used up its 3 transitions" in episode.result.ending


def test_action_that_changes_nothing_runs_out_of_time(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{track: {LOOK}}}\nactions: [track]\npolicy: {{'*': track}}\n"
        "limits: {transition_time: 0.5 s}\n"
    )
    episode = play(program, nothing)
    last = episode.at(0)[-1]
    assert (last.state, last.next_state, last.reward) == ("-", "-", 0)
    period = episode.backend.control_period
    assert 0.5 < last.ticks * period <= 0.5 + 2 * period
    assert "changed nothing" in episode.result.ending


def test_longer_time_holds_for_an_idle_action_as_well(written: Written, play: Play) -> None:
    """Extend the time of an idle action that has no limit of its own."""
    program = written(
        f"controllers: {{track: {LOOK}}}\nactions: [track]\npolicy: {{'*': track}}\n"
        "limits: {transition_time: 0.5 s}\n"
    )
    found = play(program._replace(transition_time=1.0), nothing)
    assert found.at(0)[-1].ticks * found.backend.control_period > 1.0


@pytest.mark.parametrize(
    ("action", "least", "most"),
    [("track", 0.3, 0.4), ("turn", 0.3, 0.4), ("search ◁ track", 0.4, 2.1), ("close", 2.0, 2.1)],
)
def test_action_that_moves_nothing_has_a_limit_of_its_own(
    written: Written, play: Play, action: str, least: float, most: float
) -> None:
    """Limit undefined or resting actions, but none that move or search."""
    program = written(
        f"controllers: {{track: {LOOK}, search: {SEARCH}, close: {CLOSE}, turn: {TURN}}}\n"
        f"actions: [track, search, close, turn, search ◁ track]\npolicy: {{'****': {action}}}\n"
        "limits: {transitions: 3, transition_time: 2 s, idle_time: 0.3 s}\n"
    )
    found = play(program, nothing, joints={"pan": 0.0, "tilt": 0.5})
    last = found.at(0)[-1]
    assert least < last.ticks * found.backend.control_period <= most


def test_policy_of_its_own_may_go_on_where_nothing_changed(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{track: {LOOK}, search: {SEARCH}}}\nactions: [track, search]\n"
        "policy: {'**': track}\nlimits: {transition_time: 0.2 s}\n"
    )
    asked: list[tuple[str, bool]] = []

    class Learner(Policy):
        def choose(self, state: str, *, changed: bool, features: object = None) -> Choice:
            asked.append((state, changed))
            return Choice("track" if len(asked) < 5 else None)

    episode = play(program, nothing, policy=Learner())
    assert asked == [("XX", True), ("-X", True), ("-X", False), ("-X", False), ("-X", False)]
    assert len(episode.at(0)) == 4


def test_search_goes_somewhere_else_each_time_it_came_to_rest(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{search: {SEARCH}}}\nactions: [search]\npolicy: {{'*': search}}\n"
        "limits: {transitions: 8}\n"
    )
    rests: list[np.ndarray] = []
    states = ["X"]

    def watch(tick: Tick) -> None:
        if tick.run.state == "1" != states[-1]:
            rests.append(tick.observation.positions[HEAD])
        states.append(tick.run.state)

    play(program, nothing, watch=watch)
    assert len(rests) == 4
    distances = [np.linalg.norm(a - b) for i, a in enumerate(rests) for b in rests[:i]]
    assert min(distances) > 0.2


def test_background_acts_below_every_action(checked: Checked, play: Play) -> None:
    """Move the arm home while the head searches."""
    program = checked("reachtouch")
    left_behind: list[float] = []

    def watch(tick: Tick) -> None:
        home = next(run for run in tick.run.runs if run.controller.name == "home")
        if tick.run.action is not None and tick.run.action.name == "searchtrack":
            left_behind.append(home.error)

    play(program, joints={"pan": 0.9, "right_arm_1": 1.0}, watch=watch)
    assert left_behind[1] == pytest.approx(0.46, abs=0.05)
    assert left_behind[-1] < 0.1 * left_behind[1]


def test_acting_controller_is_not_in_the_background(written: Written, play: Play) -> None:
    """Count each tick once; twice would halve the time until rest."""
    program = written(
        f"controllers: {{search: {SEARCH}, track: {LOOK}}}\nbackground: search\n"
        "actions: [search, track]\npolicy: {'**': search}\nlimits: {transitions: 1}\n"
    )

    def watch(tick: Tick) -> None:
        names = [item.run.controller.name for item in tick.run.active()]
        assert names == ["search"]

    play(program, nothing, watch=watch)


def test_program_without_an_action_to_begin_with_moves_nothing(
    written: Written, play: Play
) -> None:
    program = written(f"controllers: {{track: {LOOK}}}\nactions: [track]\npolicy: {{'1': track}}\n")
    episode = play(program)
    assert episode.backend.applied == []
    assert "own has no action for state X" in episode.result.ending


def test_composite_reads_as_its_lead(checked: Checked, play: Play) -> None:
    """Neither undefined with orient and posture defined, nor at rest with them."""
    program = checked("reachtouch")
    final: list[Tick] = []

    def watch(tick: Tick) -> None:
        final[:] = [tick]

    episode = play(program, joints={"pan": 0.9}, watch=watch)
    assert episode.at(0)[0].next_state == "X--"
    assert episode.result.predicates[-1] == "X11"
    runs = {run.controller.name: run for run in final[0].run.runs}
    assert runs["approach"].predicate == "1"
    assert not math.isnan(runs["orient"].error)
    # It came to rest away from the posture, which has the lowest priority.
    assert runs["posture"].error > 0.1


def test_composite_rests_only_with_its_optimised_part(written: Written, play: Play) -> None:
    """Complete with the manipulability, as CONDITIONEDHOLD does (Section 4.3.3)."""
    program = written(
        "controllers:\n"
        "  ahead: {potential: spring, reference: head.ahead, feedback: head, effector: head}\n"
        "  condition: {potential: manipulability, feedback: right_arm, effector: right_arm, "
        "gain: 8 /s, quiescence: {rate: 1e-3, window: 1 s}}\n"
        "  conditioned: condition ◁ ahead\n"
        "actions: [conditioned]\npolicy: {X: conditioned, '0': conditioned}\n"
    )
    waited = 0

    def watch(tick: Tick) -> None:
        nonlocal waited
        runs = {run.controller.name: run.predicate for run in tick.run.runs}
        if runs["ahead"] == "1":
            assert tick.run.state == runs["condition"]
            waited += tick.run.state == "0"

    assert play(program, nothing, watch=watch).result.predicates[-1] == "1"
    assert waited > 10


@pytest.mark.parametrize(
    ("actions", "state", "reward"), [("search, track, search ◁ track", "**", 1), ("look", "*", 0)]
)
def test_parts_of_a_named_composite_are_not_rewarded(
    written: Written, play: Play, actions: str, state: str, reward: int
) -> None:
    program = written(
        f"controllers:\n  search: {SEARCH}\n  track: {LOOK}\n  look: search ◁ track\n"
        f"actions: [{actions}]\npolicy: {{'{state}': {actions.split(', ')[-1]}}}\n"
    )
    episode = play(program)
    first = next(each for each in episode.at(0) if "1" in each.next_state)
    assert first.reward == reward


def test_rest_is_judged_from_when_nothing_is_sought(checked: Checked, play: Play) -> None:
    """Rest half a second, its window, after the contact, for an arm that waits for its hand."""
    sought: list[float] = []
    rested: list[float] = []

    def watch(tick: Tick) -> None:
        runs = {run.controller.name: run for run in tick.run.runs}
        if runs["touch"].seeking:
            assert tick.run.state == "X0-"
            sought.append(tick.observation.time)
        elif sought and runs["approach"].predicate == "1":
            rested.append(tick.observation.time)

    episode = play(
        checked("reachtouch"),
        lambda rng: World(Ball(TABLE_BALL), contact_angle=1.45),
        watch=watch,
    )
    assert sought[-1] - sought[0] > 1.0
    assert rested[0] - sought[-1] == pytest.approx(0.5, abs=0.02)
    assert episode.result.rewarded
    # Lower controllers have time to act while only the touch is not at rest yet.
    assert episode.result.predicates[-3:] == ("X00", "X10", "X11")
    last = episode.at(0)[-1]
    assert last.ticks * episode.backend.control_period > 0.4


def test_controller_without_a_dependent_search_rests(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{track: {LOOK}, close: {CLOSE}}}\n"
        "actions: [track, close, track ◁ close]\npolicy: {'**': track ◁ close}\n"
    )
    seeking: list[bool] = []

    def watch(tick: Tick) -> None:
        seeking.append(next(run for run in tick.run.runs if run.controller.seek).seeking)

    episode = play(program, watch=watch)
    assert episode.result.predicates[-1] == "1-"
    assert episode.result.rewarded
    assert all(seeking)


def test_hand_closes_only_within_the_stated_distance(checked: Checked, play: Play) -> None:
    """``seek`` waits until ``once`` has come within ``within``."""
    errors: list[float] = []
    closing: list[bool] = []

    def watch(tick: Tick) -> None:
        runs = {run.controller.name: run for run in tick.run.runs}
        errors.append(runs["approach"].error)
        closing.append(runs["touch"].seeking)

    play(checked("reachtouch"), watch=watch)
    first = closing.index(True)
    # The hand is updated before the arm moves, so it uses the arm's state of the previous tick.
    assert errors[first - 1] < 0.02
    assert all(math.isnan(error) or error >= 0.02 for error in errors[: first - 1])


def test_hand_that_closes_without_contact_stops(checked: Checked, play: Play) -> None:
    """Return to the background's reference."""
    final: list[Tick] = []
    flexed: list[float] = []

    def watch(tick: Tick) -> None:
        final[:] = [tick]
        touch = next(run for run in tick.run.runs if run.controller.name == "touch")
        flexing = touch._signals.touch.flexing["right_hand"]
        flexed.append(min(touch._signals.positions[flexing]))

    episode = play(checked("reachtouch"), lambda rng: World(Ball(TABLE_BALL)), watch=watch)
    touch = next(run for run in final[0].run.runs if run.controller.name == "touch")
    assert touch.exhausted and not touch.seeking
    assert episode.result.predicates[-1] == "X1-"
    assert 1.5 < max(flexed) < 1.6
    assert flexed[-1] < 1.4


def test_contact_ends_a_search_of_fingers(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{close: {CLOSE}}}\nactions: [close]\npolicy: {{'*': close}}\n"
    )

    def direct(world: World, time: float) -> None:
        if time > 6.0:
            world.contact_angle = GRIP

    final: list[Tick] = []

    def watch(tick: Tick) -> None:
        if tick.observation.time == pytest.approx(6.0):
            assert tick.run.runs[0].exhausted
        final[:] = [tick]

    episode = play(program, lambda rng: World(), direct, watch=watch)
    assert episode.result.rewarded
    assert "closed on nothing" not in episode.result.ending


def test_controller_that_requires_a_hold_is_undefined_without_it(
    written: Written, play: Play
) -> None:
    """From the first contact on, through moments in which a finger seeks it, to its loss."""
    turn = TURN.replace("{", "{requires: hold, ", 1)
    program = written(
        f"controllers:\n  hold: {CLOSE}\n  turn: {turn}\n  carry: turn ◁ hold\n"
        "actions: [carry]\npolicy: {'*': carry}\n"
    )

    def direct(world: World, time: float) -> None:
        world.contact_angle = 0.5 if time < 3.0 else math.inf

    seen: list[tuple[str, str]] = []

    def watch(tick: Tick) -> None:
        turning, hold = (
            next(run for run in tick.run.runs if run.controller.name == name)
            for name in ("turn", "hold")
        )
        held = "held" if hold.predicate in "01" else "sought" if hold.seeking else "lost"
        seen.append((held, "acts" if turning.predicate in "01" else "waits"))
        if not any(before[0] == "held" for before in seen):
            assert tick.observation.positions[HEAD] == pytest.approx([-0.4, 1.0])

    play(program, lambda rng: World(contact_angle=0.5), direct, watch=watch)
    passed = [each for each, _ in groupby(seen)]
    assert passed == [("sought", "waits"), ("held", "acts"), ("sought", "acts"), ("lost", "waits")]


@pytest.mark.parametrize(("action", "acts"), [("both", True), ("shift", False)])
def test_controller_that_requires_a_posture_acts_with_it(
    written: Written, play: Play, action: str, acts: bool
) -> None:
    """Treat a posture as always defined, although nothing is read for it."""
    shift = "potential: spring, reference: left_arm.home, feedback: left_arm, effector: left_arm"
    program = written(
        f"controllers:\n  turn: {TURN}\n  shift: {{requires: turn, {shift}}}\n"
        "  both: shift ◁ turn\n"
        f"actions: [both, shift]\npolicy: {{XX: {action}}}\n"
    )
    predicates: list[str] = []

    def watch(tick: Tick) -> None:
        predicates.extend(r.predicate for r in tick.run.runs if r.controller.name == "shift")

    play(program, watch=watch)
    assert predicates and set(predicates) <= ({"0", "1", "X"} if acts else {"-", "X"})
    assert ("0" in predicates) == acts


def test_controller_of_the_background_can_be_required(written: Written, play: Play) -> None:
    """Let a hand that holds during every arm motion satisfy all controllers that require it."""
    turn = TURN.replace("{", "{requires: hold, ", 1)
    program = written(
        f"controllers:\n  hold: {CLOSE}\n  turn: {turn}\n"
        "background: hold\nactions: [turn]\npolicy: {'*': turn}\n"
    )

    def direct(world: World, time: float) -> None:
        world.contact_angle = 0.5 if time > 1.0 else math.inf

    predicates: list[tuple[float, str]] = []

    def watch(tick: Tick) -> None:
        (turning,) = (run for run in tick.run.runs if run.controller.name == "turn")
        predicates.append((tick.observation.time, turning.predicate))

    play(program, lambda rng: World(contact_angle=0.5), direct, watch=watch)
    assert {letter for time, letter in predicates if 0.1 < time < 1.0} == {"-"}
    assert "0" in {letter for time, letter in predicates if time > 1.0}


def test_lost_signal_reads_undefined_and_then_in_transient(checked: Checked, play: Play) -> None:
    def direct(world: World, time: float) -> None:
        world.ball = None if 0.1 < time < 0.5 else Ball(TABLE_BALL)

    episode = play(checked("searchtrack"), lambda rng: on_table(), direct)
    tracks = [letter for letter, _ in groupby(each.next_state[1] for each in episode.at(0))]
    assert tracks == ["0", "-", "0", "1"]


def test_transition_says_when_and_for_how_long(played: Callable[[str], Played]) -> None:
    episode = played("searchtrack")
    period = episode.backend.control_period
    ends: list[Transition] = episode.at(0)
    lengths = [after.time - before.time for before, after in pairwise(ends)]
    assert lengths == pytest.approx([each.ticks * period for each in ends[1:]])


@pytest.mark.parametrize(
    ("ends", "outcome", "verdict"),
    [
        ("success: ['01']", "success", "Succeeded"),
        ("failure: ['01']", "failure", "Failed"),
        ("success: ['1X']", "", "Rewarded"),
    ],
)
def test_program_ends_in_its_states_of_success_and_failure(
    written: Written, play: Play, ends: str, outcome: str, verdict: str
) -> None:
    program = written(
        f"controllers: {{turn: {TURN}, close: {CLOSE}}}\nactions: [turn, close, turn <| close]\n"
        f'policy: {{"**": turn <| close}}\n{ends}\nlimits: {{transition_time: 3 s}}\n'
    )
    result = play(program, lambda rng: on_table(), joints={"tilt": -0.9, "pan": 1.2}).result
    assert result.predicates[-1] in ("01", "11")
    expected = outcome if result.predicates[-1] == "01" else ""
    assert result.outcome == expected
    assert result.ending.startswith(verdict)


def test_reward_need_not_end_an_episode_and_time_does(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{turn: {TURN}, close: {CLOSE}}}\nactions: [turn, close, turn <| close]\n"
        'policy: {"**": turn <| close}\n'
        "limits: {reward_ends: false, episode_time: 6 s, transition_time: 60 s}\n"
    )
    result = play(program, lambda rng: on_table()).result
    assert result.rewarded and result.succeeded
    assert result.sim_seconds == pytest.approx(6.0, abs=0.05)
    assert result.ending.startswith("Rewarded")
    assert "6 s of" in result.ending


def test_rewards_on_the_way_are_no_success(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{turn: {TURN}, close: {CLOSE}}}\nactions: [turn, close, turn <| close]\n"
        'policy: {"**": turn <| close, XX: turn}\nsuccess: [1X]\n'
        "limits: {reward_ends: false, episode_time: 6 s, transition_time: 60 s}\n"
    )
    result = play(program, lambda rng: on_table(), joints={"tilt": -0.9, "pan": 1.2}).result
    assert (result.outcome, result.rewarded, result.succeeded) == ("", True, False)
    assert result.ending.startswith("Neither succeeded nor failed after 6.0 s")


def test_learning_episode_ends_with_the_reward(written: Written, play: Play) -> None:
    program = written(
        f"controllers: {{close: {CLOSE}}}\nactions: [close]\npolicy: {{'*': close}}\n"
        "limits: {reward_ends: false, episode_time: 6 s, transition_time: 60 s}\n"
    )
    learned = play(program, lambda rng: on_table(), policy=WrittenPolicy(program.policy)).result
    assert learned.rewarded
    assert learned.sim_seconds < 5.0


@pytest.mark.parametrize("rewards", ["", "rewards: {take: [close]}\n"])
def test_parts_of_a_composition_are_rewarded_where_the_program_says_so(
    written: Written, play: Play, rewards: str
) -> None:
    program = written(
        f"controllers: {{turn: {TURN}, close: {CLOSE}, take: close <| turn}}\n"
        f"actions: [take]\npolicy: {{'*': take}}\n{rewards}limits: {{transition_time: 4 s}}\n"
    )
    result = play(program, lambda rng: on_table()).result
    assert result.rewarded == bool(rewards)


def test_required_controller_may_have_a_lower_priority(written: Written, play: Play) -> None:
    """Both become defined in the same tick."""
    turn = TURN.replace("}", ", requires: close}")
    seen: dict[str, set[str]] = {}
    for order in ("close <| turn", "turn <| close"):
        program = written(
            f"controllers: {{turn: {turn}, close: {CLOSE}}}\nactions: [turn, close, {order}]\n"
            f"policy: {{'**': {order}}}\nlimits: {{transition_time: 4 s}}\n"
        )
        result = play(program, lambda rng: on_table()).result
        seen[order] = set(result.predicates)
        assert "0-" not in result.predicates
    assert seen["close <| turn"] == seen["turn <| close"]
