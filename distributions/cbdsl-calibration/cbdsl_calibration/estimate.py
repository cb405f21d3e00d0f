"""Estimate of the cameras' displacements: robust least squares over views of a held ball."""

# Model: a camera is displaced from its modelled pose by a constant position and rotation vector,
# six unknowns. A ball lies between three fingertips, at three unknown distances in each hold. Joint
# positions give the fingertips. The expected centroid follows by trilateration and the image of a
# pinhole camera. The estimate minimises a soft L1 loss of the errors of all image points, and of a
# weak prior that the distances are alike. The ball's radius is not among these unknowns: it follows
# from the areas of the ball's images.
# Assumptions: joint positions are exact, the ball keeps its distances during a hold while it rolls,
# and the intrinsic parameters of the cameras are known.

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from cbdsl.api.documents import Camera, Correction
from cbdsl.extend.backend import Floats, UsageError
from cbdsl_calibration.ball import centre, hidden, image
from cbdsl_calibration.hand_view import FINGERS, HandView
from cbdsl_calibration.missing_motion import lacking

#: Fewest views by each camera: it has six unknowns, and each view gives two numbers.
LEAST_VIEWS = 12
#: Largest standard deviations of a useful calibration: position, m, and rotation, rad.
LARGEST_DEVIATIONS = 0.005, 0.005
# Smallest visible share of the ball; the centroid's shift by a larger hidden part is less certain.
_LEAST_VISIBLE = 0.98
# Quantile of the apparent sizes that is the whole ball's, and the refinements of its radius: each
# entry is True if the ball is taken to be wholly visible.
_WHOLE, _REFINEMENTS = 0.95, (True, True, False)
# Residual above which the robust loss treats an image point as an outlier, px.
_OUTLIER = 0.5
# Smallest standard deviation of image points, however small their residuals, px.
_LEAST_ERROR = 0.1
# Standard deviation of the ball's distances from the fingertips, which are alike, m.
_UNEVENNESS = 0.003
# Number of stretches of views that the jackknife leaves out in turn.
_STRETCHES = 10
# Share of a good calibration's motion below which no fit is tried.
_HOPELESS = 0.1
# Number of parameters of a camera: position and rotation vector.
_EACH = 6


class CalibrationError(UsageError):
    """Error of a calibration whose views do not suffice; the message gives the missing part."""


class Estimate(NamedTuple):
    """Estimate of one camera's displacement.

    Attributes:
        correction: Displacement of the camera in its link's frame.
        deviations: Largest standard deviations of position, m, and rotation, rad.
        points: Image points of the ball, px, shape (n, 2).
        before: Expected image points without calibration, px, shape (n, 2).
        after: Expected image points by an estimate made without this view, px, shape (n, 2).
    """

    correction: Correction
    deviations: tuple[float, float]
    points: Floats
    before: Floats
    after: Floats

    def error(self, expected: Floats) -> float:
        """Return the root mean square distance between seen and expected points, px."""
        return float(np.sqrt(np.mean(np.sum((self.points - expected) ** 2, axis=1))))


class _Sightings(NamedTuple):
    """Views by one camera as arrays; see ``HandView``."""

    camera: Camera
    positions: Floats
    rotations: Floats
    points: Floats
    areas: Floats
    tips: Floats
    holds: NDArray[np.intp]

    @classmethod
    def of(cls, camera: Camera, views: Sequence[HandView]) -> _Sightings:
        return cls(
            camera,
            np.array([view.position for view in views]),
            np.array([view.rotation for view in views]),
            np.array([view.point for view in views]),
            np.array([view.area for view in views]),
            np.array([view.tips for view in views]),
            np.array([view.hold for view in views], dtype=np.intp),
        )

    def among(self, chosen: NDArray[np.bool_] | slice) -> _Sightings:
        """Return some of the views."""
        return self._replace(
            positions=self.positions[chosen],
            rotations=self.rotations[chosen],
            points=self.points[chosen],
            areas=self.areas[chosen],
            tips=self.tips[chosen],
            holds=self.holds[chosen],
        )

    def within(self, own: Floats, points: Floats) -> Floats:
        """Return world points, shape (n, 3), in the frame of a camera with parameters ``own``."""
        seen = np.einsum("nji,nj->ni", self.rotations, points - self.positions) - own[:3]
        inside: Floats = seen @ Rotation.from_rotvec(own[3:]).as_matrix()
        return inside

    def fingertips(self, own: Floats) -> tuple[Floats, Floats]:
        """Return image points, px, (n, 3, 2), and distances, m, (n, 3), of the fingertips."""
        places = [self.within(own, self.tips[:, finger]) for finger in range(FINGERS)]
        points = [image(self.camera, place, 0.0)[0] for place in places]
        distances = [np.linalg.norm(place, axis=1) for place in places]
        return np.stack(points, axis=1), np.stack(distances, axis=1)


@dataclass(frozen=True)
class _Problem:
    """Least-squares problem: expected image points by parameters, and their errors.

    The parameters are each camera's position and rotation vector, in the order of ``sightings``,
    and the ball's distances from the fingertips in each hold.

    Attributes:
        sightings: Views by camera.
        side: Side of the ball, as in ``centre``.
        radius: Radius of the ball, m.
        is_whole: True if the ball is taken to be wholly visible.
    """

    sightings: Mapping[str, _Sightings]
    side: float
    radius: float
    is_whole: bool = False

    @property
    def seen(self) -> int:
        """Number of the cameras' parameters."""
        return _EACH * len(self.sightings)

    def expected(self, parameters: Floats) -> dict[str, tuple[Floats, Floats]]:
        """Return the expected centroids of the visible ball, and its visible shares, by camera."""
        expected = {}
        in_hand = parameters[self.seen :].reshape(-1, FINGERS)
        for place, (name, own) in enumerate(self.sightings.items()):
            camera = parameters[_EACH * place : _EACH * (place + 1)]
            centres = centre(own.tips, in_hand[own.holds], self.side)
            points = own.within(camera, centres)
            centroids, areas = image(own.camera, points, self.radius)
            shares, rim = own.areas / areas, np.sqrt(areas / np.pi)
            if not self.is_whole:
                tips, distances = own.fingertips(camera)
                centroids = centroids + hidden(centroids, shares, tips, distances, rim)
            expected[name] = centroids, shares
        return expected

    def residuals(self, parameters: Floats) -> Floats:
        """Return errors of image points in units of outliers, then uneven distances in theirs."""
        expected = self.expected(parameters)
        errors = [
            (expected[name][0] - own.points).ravel() / _OUTLIER
            for name, own in self.sightings.items()
        ]
        distances = parameters[self.seen :].reshape(-1, FINGERS)
        uneven = distances - distances.mean(axis=1, keepdims=True)
        # Distances that differ freely could stand for a displacement of the cameras, so they are
        # held nearly alike.
        return np.concatenate([*errors, uneven.ravel() / _UNEVENNESS])

    def cost(self, parameters: Floats) -> float:
        """Return the robust error that ``solve`` minimises."""
        return float(np.sum(np.sqrt(1.0 + self.residuals(parameters) ** 2) - 1.0))

    def solve(self, start: Floats) -> tuple[Floats, Floats]:
        """Return the parameters of least robust error, and the Jacobian of the residuals there."""
        # Metres and radians have different scales, so each unknown is scaled by its effect.
        solution = least_squares(self.residuals, start, loss="soft_l1", x_scale="jac")
        return solution.x, solution.jac

    def among(self, chosen: Mapping[str, NDArray[np.bool_] | slice]) -> _Problem:
        """Return the problem over some of the views by each camera."""
        some = {name: own.among(chosen[name]) for name, own in self.sightings.items()}
        return replace(self, sightings=some)


def estimate(cameras: Mapping[str, Camera], views: Sequence[HandView]) -> dict[str, Estimate]:
    """Estimate the displacement of each camera.

    The unknowns are the cameras' positions and rotations and the ball's distances from the
    fingertips. The ball's radius follows from its apparent size. Views in which fingers hide a part
    of the ball are left out.

    Args:
        cameras: Cameras of the robot, by name.
        views: Views of a ball that a hand holds, by any of the cameras.

    Raises:
        CalibrationError: If there are too few views, or they do not determine the displacements.
    """
    numbers = {hold: number for number, hold in enumerate(sorted({v.hold for v in views}))}
    views = [view._replace(hold=numbers[view.hold]) for view in views]
    by_camera = {name: [view for view in views if view.camera == name] for name in cameras}
    _require_views({name: len(own) for name, own in by_camera.items()})
    if hopeless := lacking(by_camera, _HOPELESS):
        raise CalibrationError(f"these views do not tell where the cameras are: {hopeless}")
    problem, start = _prepare(cameras, by_camera)
    parameters, jacobian = problem.solve(start)
    deviations = _deviations(problem, parameters, jacobian)
    worst = deviations.max(axis=0)
    if not (worst[0] <= LARGEST_DEVIATIONS[0] and worst[1] <= LARGEST_DEVIATIONS[1]):
        raise CalibrationError(
            f"these views leave the cameras uncertain by {1000 * worst[0]:.2g} mm and "
            f"{np.rad2deg(worst[1]):.2g} deg: "
            f"{lacking(by_camera) or 'gather more views'}"
        )
    return _estimates(problem, parameters, deviations)


def _require_views(numbers: Mapping[str, int]) -> None:
    if few := [f"{name} in {n}" for name, n in numbers.items() if n < LEAST_VIEWS]:
        raise CalibrationError(
            f"too few views of the whole ball while the hand holds it (camera {', '.join(few)}; "
            f"{LEAST_VIEWS} are needed): show it longer, farther from the images' borders, and "
            "with the palm towards the cameras"
        )


def _prepare(
    cameras: Mapping[str, Camera], views: Mapping[str, Sequence[HandView]]
) -> tuple[_Problem, Floats]:
    """Return the problem over the views of nearly the whole ball, and the start of its solution.

    The images decide on which side of the fingertips' plane the ball is. Forces cannot, since those
    on a held ball add up to its weight.
    """
    everything = [view for own in views.values() for view in own]
    radius = _apparent_radius(cameras, views)
    sightings = {name: _Sightings.of(cameras[name], own) for name, own in views.items()}
    holds = 1 + max(view.hold for view in everything)
    start = np.concatenate([np.zeros(_EACH * len(views)), np.full(FINGERS * holds, 1.15 * radius)])
    problem, start = min(
        (_refine(_Problem(sightings, side, radius), start) for side in (1.0, -1.0)),
        key=lambda refined: refined[0].cost(refined[1]),
    )
    shares = {name: share for name, (_, share) in problem.expected(start).items()}
    whole = _share_of_whole_balls(shares)
    visible = {name: share >= _LEAST_VISIBLE * whole for name, share in shares.items()}
    _require_views({name: int(chosen.sum()) for name, chosen in visible.items()})
    return problem.among(visible), start


def _refine(problem: _Problem, start: Floats) -> tuple[_Problem, Floats]:
    """Return a problem with the radius by its views, and the parameters before it changed."""
    for is_whole in _REFINEMENTS:
        # The hidden part follows from the radius, which hardly affects the position of a whole
        # ball.
        problem = replace(problem, is_whole=is_whole)
        start, _ = problem.solve(start)
        shares = {name: share for name, (_, share) in problem.expected(start).items()}
        problem = replace(problem, radius=problem.radius * math.sqrt(_share_of_whole_balls(shares)))
    return problem, start


def _share_of_whole_balls(shares: Mapping[str, Floats]) -> float:
    return float(np.quantile(np.concatenate(list(shares.values())), _WHOLE))


def _apparent_radius(
    cameras: Mapping[str, Camera], views: Mapping[str, Sequence[HandView]]
) -> float:
    """Return the ball's apparent radius at the distance of the fingertips, m."""
    radii = [
        math.sqrt(view.area / math.pi)
        * np.linalg.norm(view.tips.mean(axis=0) - view.position)
        / cameras[name].focal_length
        for name, own in views.items()
        for view in own
    ]
    return float(np.median(radii))


def _deviations(problem: _Problem, parameters: Floats, jacobian: Floats) -> Floats:
    """Return the largest deviations of each camera's position and rotation, shape (cameras, 2).

    Each is the larger of two standard deviations. The first assumes independent errors of the
    views. The second is the jackknife over stretches of views, whose errors are correlated: while
    the hand moves little, ball and fingers change little.
    """
    unknown = len(parameters) - problem.seen
    errors = problem.residuals(parameters)[:-unknown] * _OUTLIER
    # Half of the errors are less than 0.67 standard deviations, outliers or not.
    error = max(float(np.median(np.abs(errors))) / 0.6745, _LEAST_ERROR)
    # The covariance is s^2 (J' J)^-1. The bound keeps directions finite that no view determines:
    # their deviations are huge, and are refused.
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    spread = np.maximum(values, 1e-12 * values[-1])
    independent = (vectors / spread) @ vectors.T * (error / _OUTLIER) ** 2
    without = np.array([each.solve(parameters)[0] for each in _without_stretches(problem)])
    shifts = without - without.mean(axis=0)
    # Covariance of the delete-a-group jackknife.
    alike = shifts.T @ shifts * (_STRETCHES - 1) / _STRETCHES
    seen = problem.seen
    return np.maximum(_largest(independent[:seen, :seen]), _largest(alike[:seen, :seen]))


def _without_stretches(problem: _Problem) -> Iterator[_Problem]:
    """Yield the problem without each stretch of views, by all cameras, in turn."""
    stretches = {
        name: np.arange(len(own.points)) * _STRETCHES // len(own.points)
        for name, own in problem.sightings.items()
    }
    for stretch in range(_STRETCHES):
        yield problem.among({name: own != stretch for name, own in stretches.items()})


def _largest(covariance: Floats) -> Floats:
    """Return the largest standard deviations of positions and rotations, shape (cameras, 2)."""
    starts = range(0, len(covariance), 3)
    blocks = [covariance[start : start + 3, start : start + 3] for start in starts]
    return np.sqrt([np.linalg.eigvalsh(block)[-1] for block in blocks]).reshape(-1, 2)


def _estimates(problem: _Problem, parameters: Floats, deviations: Floats) -> dict[str, Estimate]:
    """Return the estimates; each half of the views is predicted from the other half."""
    uncalibrated = np.concatenate([np.zeros(problem.seen), parameters[problem.seen :]])
    before = problem.expected(uncalibrated)
    after = {name: np.empty_like(own.points) for name, own in problem.sightings.items()}
    for half in range(2):
        other = dict.fromkeys(problem.sightings, slice(1 - half, None, 2))
        fitted, _ = problem.among(other).solve(parameters)
        for name, (points, _) in problem.expected(fitted).items():
            after[name][half::2] = points[half::2]
    estimates = {}
    for place, (name, own) in enumerate(problem.sightings.items()):
        position, rotation = np.split(parameters[_EACH * place : _EACH * (place + 1)], 2)
        largest = float(deviations[place, 0]), float(deviations[place, 1])
        correction = Correction(position=_three(position), rotation=_three(rotation))
        estimates[name] = Estimate(correction, largest, own.points, before[name][0], after[name])
    return estimates


def _three(values: Floats) -> tuple[float, float, float]:
    """Return three numbers, rounded to a thousandth of a millimetre or milliradian."""
    x, y, z = (round(float(value), 6) for value in values)
    return x, y, z
