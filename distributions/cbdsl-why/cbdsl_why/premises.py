"""Premises of all causes: clock, drives, load cells and cameras agree with each other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cbdsl_why.contact_causes import BETWEEN, approached, attempts, contact
from cbdsl_why.history import CONTACT, SHOWN, History, Mask, spans
from cbdsl_why.orientations import turned_hand
from cbdsl_why.wrong_objects import one_sided, unmoved

# Share of a period by which a tick may be late, and share of late ticks.
_JITTER, _OFTEN = 0.5, 0.05
# Lag behind all recent references above which a joint does not follow, as a share of the largest
# lead, and for a sliding joint, m. Successful episodes of four robots stay below a fifth and 1 mm.
_LAG, _SLID = 0.25, 2e-3
# Time that a contradiction lasts, s.
_LASTS = 0.3
# Number of ticks for which a joint runs ahead, and time after a contact in which it may, s.
_RUNS, _LATELY = 3, 0.5
# Reversals of a reference within a second that no task has, and the least step of one, rad.
_REVERSALS, _STEP = 12, 1e-3
# Motion of a joint by an object that stops its arm, as a share of the largest lead.
_THROWN = 0.75
# Force of a cell, N, from which its contact holds a joint back, and that a drive with a lag exerts;
# and the share of that lag that a free joint has.
_FELT, _FREE = 1.0, 0.1
# Share of the grip above which a load is not held by friction alone.
_OVERLOAD = 0.9
# Load of an object that is no matter of fingers that move, N.
_LOAD = 1.0
# Time of images without a match that is no matter of partial views, s.
_UNMATCHED = 1.0
# Distance that a hand carries an object, and that the object then seems to have moved, m.
_CARRIED, _STAYED = 0.06, 0.02
# Distance of a held object from the spread fingers, m.
_HOLDS = 0.02
# Force of fingers, N, and time, s, that a free object does not stand.
_STANDS, _STANDS_LONG = 3.5, 2.0
# Time between two headings, s, a turn of the cameras, rad, the share of it by which the heading of
# an object at rest changes at least, and the heading of an object that no head follows, rad.
_LOOK, _TURNED, _FOLLOWS, _ASIDE = 0.5, 0.2, 0.2, 0.1
# Displacement of an object that no hand touched, m, and its least distance from any hand, m.
_WANDERED, _FAR = 0.05, 0.2
# Share of the distance of the open fingers up to which they have closed.
_CLOSED = 0.5


class Doubt(NamedTuple):
    """Contradiction between recorded facts, from which on no cause can be trusted.

    Attributes:
        tick: First tick in which it shows.
        clause: The facts, with their numbers.
    """

    tick: int
    clause: str


def doubts(history: History) -> list[Doubt]:
    """Return the contradictions of a recording by time."""
    finders = (
        _clock, _drives, _runaways, _readings, _fingers, _overloads, _reversals, _views, _carries,
        _closings, _wanders, _stands, _idle_loads, _stale_images,
    )  # fmt: skip
    contradictions = [doubt for find in finders for doubt in find(history)]
    return sorted(contradictions, key=lambda each: each.tick)


def _clock(history: History) -> Iterator[Doubt]:
    """Yield a clock whose ticks have no common period."""
    periods = np.diff(history.time)
    usual = float(np.median(periods)) if len(periods) else 0.0
    uneven = np.flatnonzero(np.abs(periods - usual) > _JITTER * usual)
    if len(uneven) > _OFTEN * len(periods):
        share = 100 * len(uneven) / len(periods)
        clause = f"{share:.0f} % of the ticks were early or late by more than half a period"
        yield Doubt(int(uneven[0]), clause)


def _drives(history: History) -> Iterator[Doubt]:
    """Yield joints that moved, but away from their references, where nothing was felt.

    A joint that stands still has a cause: ``not_followed``.
    """
    positions = history.recorded.arrays["positions"]
    fingers = set(history.cell_joints.values())
    # An arm that stands on something is thrown off, and felt it a moment ago.
    free = ~history.touches & ~(_lately(history, history.touches) & history.near)
    for joint, name in enumerate(history.summary["joints"]):
        late = (history.lags[:, joint] > _allowed(history, joint)) & free
        for first, last in spans(late) if joint not in fingers else ():
            moved = float(np.ptp(positions[first : last + 1, joint]))
            if last - first >= history.ticks(_LASTS) and moved > _least(
                history, joint, first, last
            ):
                lag, unit = float(history.lags[first:last, joint].max()), history.unit(joint)
                clause = (
                    f"joint {name} moved by {moved:.2g} {unit}, up to {lag:.2g} {unit} from its"
                )
                yield Doubt(first, f"{clause} references: its load, drive or encoder differ")
                break


def _least(history: History, joint: int, first: int, last: int) -> float:
    """Return the least motion of a joint between two ticks, rad or m, that no contact explains.

    An object or its stand may stop a hand beside its load cells, and turns it a little.
    """
    lead: float = history.summary["robot"].get("lead") or np.inf
    is_near = history.near[first : last + 1].any()
    return _THROWN * lead if is_near else _allowed(history, joint)


def _runaways(history: History) -> Iterator[Doubt]:
    """Yield joints that ran ahead of their references where nothing was felt.

    A drive pulls a joint behind its reference. Another force drives one that is ahead of it.
    """
    arrays, fingers = history.recorded.arrays, set(history.cell_joints.values())
    ahead = arrays["positions"] - arrays["references"]
    ways = np.sign(np.gradient(arrays["positions"], axis=0)) if len(ahead) > 1 else 0.0 * ahead
    free = ~_lately(history, history.touches)
    allowed = np.array([_allowed(history, joint) for joint in range(ahead.shape[1])])
    late = history.lags > allowed
    for joint, name in enumerate(history.summary["joints"]):
        lead = np.minimum(ahead[:, joint] * ways[:, joint], history.lags[:, joint])
        runs = (lead > allowed[joint]) & free
        for first, last in spans(runs) if joint not in fingers else ():
            ran = np.ptp(arrays["positions"][first : last + 1, joint])
            # A joint that something stopped before may swing.
            followed = not late[max(0, first - history.ticks(_LATELY)) : first, joint].any()
            if followed and last - first >= _RUNS and ran > _least(history, joint, first, last):
                size, unit = float(lead[first : last + 1].max()), history.unit(joint)
                clause = f"joint {name} ran {size:.2g} {unit} ahead of its reference"
                yield Doubt(first, f"{clause}, and nothing was felt: another force drove it")
                break


def _lately(history: History, mask: Mask) -> Mask:
    """Return the ticks in which a mask (T,) holds, or did a moment ago."""
    sums = np.cumsum(np.concatenate([np.zeros(history.ticks(_LATELY) + 1, dtype=int), mask]))
    window = history.ticks(_LATELY)
    lately: Mask = sums[window + 1 :] > sums[: -window - 1]
    return lately


def _readings(history: History) -> Iterator[Doubt]:
    """Yield joints whose readings jump."""
    # Fingers in contact jerk.
    jumps = np.abs(np.diff(history.recorded.arrays["positions"], n=2, axis=0))
    jumps = jumps[~(history.touches | history.near)[1:-1]]
    for joint, name in enumerate(history.summary["joints"]):
        ticks = np.flatnonzero(jumps[:, joint] > _allowed(history, joint))
        if len(ticks) > _OFTEN * len(jumps):
            size, unit = float(np.median(jumps[ticks, joint])), history.unit(joint)
            yield Doubt(int(ticks[0]), f"joint {name} read jumps of {size:.2g} {unit}")


def _fingers(history: History) -> Iterator[Doubt]:
    """Yield fingers whose load cells and drives contradict each other.

    A drive pushes by the lag of its joint, and a felt force holds a joint back.
    """
    forces = np.linalg.norm(history.cell_forces, axis=2)
    for cell, joint in history.cell_joints.items():
        # A finger that no force controller moves may be pressed along or beside its links.
        closes = history.closes(cell.split(".")[0])
        force = forces[:, history.summary["load_cells"].index(cell)]
        lag, allowed, unit = history.lags[:, joint], _allowed(history, joint), history.unit(joint)
        name = history.summary["joints"][joint]
        # Some drives are too stiff to show a force.
        yields = bool((lag > allowed).any())
        # A hand that stands on something presses with its links as well.
        stands = history.pushes(cell.split(".")[0])
        stopped = f"joint {name} was {{:.2g}} {unit} behind its reference"
        for contradiction, clause in (
            (
                (force < _FELT) & (lag > allowed) & closes & ~stands,
                f"{stopped}, and {cell} felt {{:.2g}} N",
            ),
            (
                (force > _FELT) & (lag < _FREE * allowed) & closes & yields,
                f"{stopped} only, and {cell} felt {{:.2g}} N",
            ),
        ):
            for first, last in spans(contradiction):
                if last - first >= history.ticks(_LASTS) and not _is_off(history, cell, first):
                    middle = (first + last) // 2
                    yield Doubt(first, clause.format(lag[middle], force[middle]))
                    break


def _is_off(history: History, cell: str, tick: int) -> bool:
    """Return whether a hand is turned or beside its object, and presses beside its cells."""
    hand = cell.split(".")[0]
    place = approached(history, tick, hand)
    radius = BETWEEN * history.spread(hand, tick)
    is_beside = place is not None and history.beside(hand, tick, place[1]) > radius > 0.0
    return is_beside or turned_hand(history, hand, tick, cell) is not None


def _overloads(history: History) -> Iterator[Doubt]:
    """Yield slips of objects whose load was too large for the grip, for an unknown reason."""
    loads = history.cell_forces
    cells = history.summary["load_cells"]
    for slip in contact(history):
        hand = slip.sentence.split(":")[0].rsplit(" ", 1)[-1]
        columns = [n for n, cell in enumerate(cells) if cell.split(".")[0] == hand]
        if slip.kind != "slip" or not columns:
            continue
        before = loads[max(0, slip.tick - history.ticks(_LASTS)) : slip.tick, columns]
        load = np.linalg.norm(before.sum(axis=1), axis=1)
        grip = np.linalg.norm(before, axis=2).sum(axis=1)
        most = int(np.argmax(load / np.maximum(grip, CONTACT)))
        if load[most] > max(_LOAD, _OVERLOAD * grip[most]):
            clause = f"{hand} bore {load[most]:.1f} N by {grip[most]:.1f} N of grip when the object"
            yield Doubt(slip.tick, f"{clause} slipped: it is heavy, or something held it")


def _reversals(history: History) -> Iterator[Doubt]:
    """Yield joints whose references swing back and forth."""
    steps = np.diff(history.recorded.arrays["references"], axis=0)
    second = history.ticks(1.0)
    lead = history.summary["robot"].get("lead") or np.inf
    pressed = history.touches | (history.lags > _LAG * lead).any(axis=1)
    for joint, name in enumerate(history.summary["joints"]):
        # An arm that presses on something is thrown back again and again.
        moving = np.flatnonzero((np.abs(steps[:, joint]) > _STEP) & ~pressed[1:])
        turns = moving[1:][np.diff(np.sign(steps[moving, joint])) != 0]
        many = turns[_REVERSALS:] - turns[:-_REVERSALS] < second
        if many.any():
            first = int(turns[np.flatnonzero(many)[0]])
            clause = f"the references of joint {name} reversed {_REVERSALS} times within a second"
            yield Doubt(first, clause)


def _views(history: History) -> Iterator[Doubt]:
    """Yield objects that both cameras see, and nowhere in common."""
    for channel in history.summary.get("channels", ()):
        codes = np.array(history.sight(channel))
        # A hand at an object covers a part of it.
        unmatched = np.flatnonzero((codes == "unmatched") & ~history.near[: len(codes)])
        if len(unmatched) > history.ticks(_UNMATCHED):
            seconds = len(unmatched) * float(np.median(np.diff(history.time)))
            clause = (
                f"each camera saw one {channel} region, for {seconds:.1f} s not at one position"
            )
            yield Doubt(int(unmatched[0]), f"{clause}: images or calibration differ")


def _carries(history: History) -> Iterator[Doubt]:
    """Yield objects that were seen to stay where a hand had carried them away."""
    for hand in history.hands:
        holds = [each for each in history.courses if each.hand == hand and each.grasps]
        for first, last in spans(np.any([history.rests(each) for each in holds], axis=0)):
            place = approached(history, first, hand)
            if place is None or last - first < history.ticks(_LASTS):
                continue
            ticks = np.arange(first, last, max(1, history.ticks(0.1)))
            centres = np.array([history.fingers(hand, int(tick)).mean(axis=0) for tick in ticks])
            seen = history.sees(place[0], SHOWN)[ticks]
            values = history.places[place[0]][ticks]
            # A hand that holds an object may have approached its goal since.
            reach = _HOLDS + 2.0 * history.spread(hand, first)
            if not np.linalg.norm(values[0] - centres[0]) < reach:
                continue
            gone = seen & (np.linalg.norm(centres - centres[0], axis=1) > _CARRIED)
            stayed = np.linalg.norm(values - values[0], axis=1) < _STAYED
            if (gone & stayed).any():
                tick = int(ticks[np.flatnonzero(gone & stayed)[0]])
                clause = f"{hand} carried an object away, and {place[0]} was seen to stay"
                yield Doubt(tick, clause)
                break


def _closings(history: History) -> Iterator[Doubt]:
    """Yield hands that closed where an object was seen between their fingers."""
    for attempt in attempts(history):
        place = approached(history, attempt.first, attempt.course.hand)
        opened, closed = (history.spread(attempt.course.hand, t) for t in attempt[1:])
        if place is None or closed > _CLOSED * opened:
            continue
        beside = history.beside(attempt.course.hand, attempt.last, place[1])
        if beside < BETWEEN * opened and history.sees(place[0], SHOWN)[attempt.last]:
            clause = f"{attempt.course.name} closed where {place[0]} was seen, and felt nothing"
            yield Doubt(attempt.last, clause)
            return


def _wanders(history: History) -> Iterator[Doubt]:
    """Yield objects that were seen to move before any hand touched or reached them."""
    if not history.hands:
        return  # such a program may follow an object that moves
    touched = np.flatnonzero(
        np.max([history.forces(each) for each in history.hands], axis=0) > CONTACT
    )
    until = int(touched[0]) if len(touched) else len(history.time)
    for signal, values in history.places.items():
        seen = np.flatnonzero(history.sees(signal, ("seen",))[:until])
        moves = np.linalg.norm(values[seen] - values[seen[:1]], axis=1)
        beyond = seen[moves > _WANDERED]
        # One tick may be a wrong match.
        if len(beyond) < history.ticks(_LASTS):
            continue
        tick = int(beyond[history.ticks(_LASTS) - 1])
        hands = [history.fingers(hand, tick) for hand in history.hands]
        if all(
            np.linalg.norm(each - values[tick], axis=1).min() > _FAR for each in hands if len(each)
        ):
            clause = f"{signal} moved by {100 * moves.max():.1f} cm, and no hand was at it"
            yield Doubt(int(seen[moves > _WANDERED / 5][0]), clause)


def _stands(history: History) -> Iterator[Doubt]:
    """Yield objects that stood the force of a finger before others were at them."""
    for course in history.courses:
        if not (course.grasps and course.member):
            continue
        for first, last in spans(course.flag("seeking") & ~course.defined):
            place = approached(history, first, course.hand)
            if place is None:
                continue
            for begin, end, force in unmoved(history, course.hand, (first, last), place[0]):
                is_beside = one_sided(history, course, (begin, end), place[0])
                if force > _STANDS and end - begin > history.ticks(_STANDS_LONG) and not is_beside:
                    clause = f"{course.hand} pressed by {force:.1f} N from one side"
                    yield Doubt(begin, f"{clause}, and {place[0]} stayed: it is heavy, or fixed")
                    return


def _idle_loads(history: History) -> Iterator[Doubt]:
    """Yield load cells that all feel a force while their hand moves open, far from objects."""
    for hand in dict.fromkeys(cell.split(".")[0] for cell in history.summary["load_cells"]):
        forces = np.linalg.norm(history.cell_forces[:, history.cells_of(hand)], axis=2).min(axis=1)
        idle = (forces > CONTACT) & ~history.closes(hand) & ~history.near
        for first, last in spans(idle):
            fingers = [history.fingers(hand, tick) for tick in (first, last)]
            if (
                len(fingers[0]) < 2
                or np.linalg.norm(np.subtract(*fingers), axis=1).min() < _CARRIED
            ):
                continue
            clause = f"{hand} moved open and far from objects, and all its cells felt"
            yield Doubt(first, f"{clause} {forces[first : last + 1].max():.1f} N")
            break


def _stale_images(history: History) -> Iterator[Doubt]:
    """Yield headings that stay beside the middle of the images while the cameras turn.

    The heading of an object at rest turns against the cameras. A head that follows an object keeps
    it in the middle.
    """
    links = [each["link"] for each in history.summary["robot"].get("cameras", {}).values()]
    turns = history.turns(links[0]) if links else np.zeros((0, 3, 3))
    window = history.ticks(_LOOK)
    if len(turns) <= window:
        return
    cosines = (np.einsum("tij,tij->t", turns[window:], turns[:-window]) - 1.0) / 2.0
    angles = np.arccos(np.clip(cosines, -1.0, 1.0))
    for name, facts in history.summary["signals"].items():
        if facts["type"] != "heading":
            continue
        values = history.recorded.signals[name]
        changes = np.linalg.norm(values[window:] - values[:-window], axis=1)
        aside = np.linalg.norm(values[window:], axis=1) > _ASIDE
        stale = np.flatnonzero((angles > _TURNED) & (changes < _FOLLOWS * angles) & aside)
        if len(stale) > window // 2:
            clause = f"the cameras turned by {angles[stale].max():.2f} rad, and {name} stayed aside"
            yield Doubt(int(stale[0]), f"{clause}: the images are old")


def _allowed(history: History, joint: int) -> float:
    """Return the lag that a free joint has, rad or m."""
    lead = history.summary["robot"].get("lead") or np.inf
    return _SLID if history.unit(joint) == "m" else _LAG * lead
