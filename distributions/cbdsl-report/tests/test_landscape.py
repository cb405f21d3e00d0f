"""Densities as functions: the densities that references are drawn from."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cbdsl.documents.model import Gaussian, Kernel, ModelDocument
from cbdsl.program.binding import density_source
from cbdsl.sensing.density import DensitySampler
from cbdsl_report.density_svg import density_svgs
from cbdsl_report.landscape import Landscape
from cbdsl_report.learned_files import InternalModel, Joint

# Some beyond the limits, none so far that only a steep tail is left within them.
ANGLES = st.floats(-0.7, 1.2)
WIDTHS = st.floats(0.1, 1.0)
SHARES = st.floats(0, 1)
ENDLESS = (Joint("pan", -np.inf, np.inf), Joint("tilt", -0.5, 1.0))
JOINTS = (Joint("pan", -1.0, 1.5), Joint("tilt", -0.5, 1.0))


def pairs(each: st.SearchStrategy[float]) -> st.SearchStrategy[tuple[float, ...]]:
    return st.tuples(each, each)


DENSITIES = st.one_of(
    st.builds(
        Gaussian,
        form=st.just("gaussian"),
        mean=pairs(ANGLES),
        deviation=pairs(WIDTHS),
        uniform=SHARES,
    ),
    st.builds(
        Kernel,
        form=st.just("kernel"),
        samples=st.lists(pairs(ANGLES), min_size=1, max_size=6).map(tuple),
        bandwidth=pairs(WIDTHS),
        uniform=SHARES,
    ),
)


def landscape_document(density: Gaussian | Kernel) -> ModelDocument:
    return ModelDocument(cbdsl=1, kind="model", name="m", robot="r", effector="e", density=density)


def landscape(density: Gaussian | Kernel) -> Landscape:
    return Landscape(InternalModel("head.likely", landscape_document(density), JOINTS))


def mean_over(values: np.ndarray) -> np.ndarray:
    """Return the mean along the last axis, by the trapezoidal rule."""
    return (values[..., 1:] + values[..., :-1]).mean(axis=-1) / 2


@given(DENSITIES)
@settings(max_examples=30)
def test_relative_density_is_one_on_average(density: Gaussian | Kernel) -> None:
    found = landscape(density)
    whole = found.over(found.angles(0), found.angles(1))
    # The rule is right within 0.3 % for the narrowest density that is cut off at a limit.
    assert mean_over(mean_over(whole)) == pytest.approx(1, abs=5e-3)
    assert (whole >= density.uniform - 1e-12).all()


@given(DENSITIES)
@settings(max_examples=30)
def test_density_along_one_joint_is_the_mean_over_the_other(density: Gaussian | Kernel) -> None:
    found = landscape(density)
    whole = found.over(found.angles(0), found.angles(1))
    assert mean_over(whole) == pytest.approx(found.along(1, found.angles(1)), 3e-3, 5e-3)
    assert mean_over(whole.T) == pytest.approx(found.along(0, found.angles(0)), 3e-3, 5e-3)


@given(DENSITIES)
@settings(max_examples=10, deadline=None)
def test_draws_of_a_model_follow_its_landscape(density: Gaussian | Kernel) -> None:
    found = landscape(density)
    sampler = DensitySampler(
        density_source("e", density), found.lower, found.upper, np.random.default_rng(0)
    )
    draws = np.array([sampler.draw() for _ in range(1500)])
    for joint in range(2):
        counts, edges = np.histogram(draws[:, joint], 6, (found.lower[joint], found.upper[joint]))
        for count, low, high in zip(counts, edges, edges[1:], strict=False):
            expected = mean_over(found.along(joint, np.linspace(low, high, 50))) / 6
            assert abs(count / len(draws) - expected) < 0.06


@given(DENSITIES)
@settings(max_examples=20)
def test_peak_is_the_largest_density(density: Gaussian | Kernel) -> None:
    found = landscape(density)
    (first, second), most = found.peak()
    assert found.over(np.array([first]), np.array([second]))[0, 0] == pytest.approx(most)
    assert found.over(found.angles(0), found.angles(1)).max() <= most + 1e-12


def test_density_of_a_joint_without_limits_is_shown_over_one_turn() -> None:
    density = Gaussian(form="gaussian", mean=(0.5, 0.2), deviation=(0.3, 0.3), uniform=0.2)
    document = ModelDocument(
        cbdsl=1, kind="model", name="m", robot="r", effector="e", density=density
    )
    found = Landscape(InternalModel("head.likely", document, ENDLESS))
    whole = found.over(found.angles(0), found.angles(1))
    assert mean_over(mean_over(whole)) == pytest.approx(1, abs=5e-3)
    assert found.angles(0)[[0, -1]] == pytest.approx([-np.pi, np.pi])


def test_density_beyond_the_limits_is_drawn_as_nothing() -> None:
    far = Gaussian(form="gaussian", mean=(90.0, 0.0), deviation=(0.1, 0.1))
    document = ModelDocument(cbdsl=1, kind="model", name="m", robot="r", effector="e", density=far)
    found = landscape(far)
    assert not found.over(found.angles(0), found.angles(1)).any()
    (picture,) = density_svgs(InternalModel("head.likely", document, JOINTS))
    assert "nan" not in picture and "inf" not in picture


@pytest.mark.parametrize("form", ["gaussian", "kernel"])
@pytest.mark.parametrize("turns", [0, 1, -3])
def test_density_of_a_joint_without_limits_goes_on_at_half_a_turn(form: str, turns: int) -> None:
    center, angle = np.pi - 0.05 + 2 * np.pi * turns, 0.4
    density = (
        Gaussian(form="gaussian", mean=(center, 0.2), deviation=(angle, 0.2))
        if form == "gaussian"
        else Kernel(form="kernel", samples=((center, 0.2),), bandwidth=(angle, 0.2))
    )
    model = InternalModel("m", landscape_document(density), ENDLESS)
    found = Landscape(model)
    along = found.along(0, found.angles(0))
    assert along[0] == pytest.approx(along[-1])
    assert mean_over(along) == pytest.approx(1, abs=5e-3)
    assert along[0] > 5 * along[len(along) // 2]
    (picture,) = density_svgs(model)
    assert "nan" not in picture and "inf" not in picture and "pan, degrees" in picture


def test_density_of_sliding_joints_is_drawn_in_mm() -> None:
    density = Gaussian(form="gaussian", mean=(0.02, 0.5), deviation=(0.01, 0.1), uniform=0)
    document = landscape_document(density)
    joints = (Joint("slide", 0.0, 0.04, "m"), Joint("hinge", 0.0, 1.0, "rad"))
    (picture,) = density_svgs(InternalModel("m", document, joints))
    assert "slide, mm" in picture and "hinge, degrees" in picture and "slide 20 mm" in picture
