"""Refinement of known bodies: the reported error holds, surfaces are closed, small parts are found or reported."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from cablewright.analyses.workspace import refinement
from cablewright.analyses.workspace.refinement import Refined, RefinementSettings, SearchBox, refine

CUBE = SearchBox(np.array([-1.0, -1.0, -1.0]), np.array([1.0, 1.0, 1.0]))
Body = Callable[[np.ndarray], np.ndarray]


def ball(radius: float, middle: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Body:
    return lambda places: radius - np.linalg.norm(places - np.array(middle), axis=1)


def shell(places: np.ndarray) -> np.ndarray:
    return np.minimum(ball(0.9)(places), -ball(0.5)(places))


def corner(places: np.ndarray) -> np.ndarray:
    return 0.7 - (places + 1.0).sum(axis=1)


def torus(places: np.ndarray) -> np.ndarray:
    return 0.25 - np.hypot(np.hypot(places[:, 0], places[:, 1]) - 0.6, places[:, 2])


def two_boxes(places: np.ndarray) -> np.ndarray:
    """Sharp edges, askew to no axis, off the lattice."""
    one = np.min(0.311 - np.abs(places - 0.4), axis=1)
    other = np.min(0.217 - np.abs(places + 0.5), axis=1)
    return np.maximum(one, other)


BODIES: dict[str, tuple[Body, float]] = {
    "ball": (ball(0.8), 4 / 3 * np.pi * 0.8**3),
    "shell": (shell, 4 / 3 * np.pi * (0.9**3 - 0.5**3)),
    "corner": (corner, 0.7**3 / 6),
    "torus": (torus, 2 * np.pi**2 * 0.6 * 0.25**2),
    "boxes": (two_boxes, 8 * (0.311**3 + 0.217**3)),
    "full": (lambda places: np.ones(len(places)), 8.0),
    "beyond": (ball(3.0), 8.0),
}


def found(body: Body, box: SearchBox = CUBE, *, sign: bool = False, **options: object) -> Refined:
    def margin(places: np.ndarray, purpose: str) -> np.ndarray:
        values = body(places)
        return np.where(values >= 0, 1.0, -1.0) if sign else values

    return refine(margin, box, RefinementSettings(**options))


@pytest.mark.parametrize("sign", [False, True])
@pytest.mark.parametrize("name", BODIES)
def test_volumes_are_within_their_error(name: str, sign: bool) -> None:
    body, known = BODIES[name]
    got = found(body, sign=sign)
    assert got.converged
    assert got.mesh.is_closed
    assert abs(got.mesh.volume - known) <= got.error
    assert got.error <= 2e-3 * got.mesh.volume


def test_a_tighter_tolerance_is_kept() -> None:
    body, known = BODIES["ball"]
    got = found(body, tolerance=4e-4)
    assert abs(got.mesh.volume - known) <= got.error <= 4e-4 * got.mesh.volume
    assert got.cells[0] > found(body).cells[0]


def test_the_surface_is_on_the_body() -> None:
    mesh = found(ball(0.8)).mesh
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 0.8, atol=2e-4)
    plain = found(ball(0.8), sign=True).mesh
    np.testing.assert_allclose(np.linalg.norm(plain.vertices, axis=1), 0.8, atol=2 * np.sqrt(3) / 64 / 16)


def test_a_symmetric_body_has_a_symmetric_surface() -> None:
    mesh = found(torus).mesh
    rows = {tuple(row) for row in np.round(mesh.vertices, 9) + 0.0}
    for flip in (np.array([-1, 1, 1]), np.array([1, -1, 1]), np.array([1, 1, -1])):
        assert {tuple(row) for row in np.round(mesh.vertices * flip, 9) + 0.0} == rows
    assert {tuple(row) for row in np.round(mesh.vertices[:, [1, 0, 2]], 9) + 0.0} == rows


def test_a_function_that_jumps_is_bisected() -> None:
    def jumps(places: np.ndarray) -> np.ndarray:
        return np.where(ball(0.8)(places) >= 0, 1.0, -np.inf)

    got = found(jumps)
    assert abs(got.mesh.volume - BODIES["ball"][1]) <= got.error


def test_nan_is_outside() -> None:
    got = found(lambda places: np.where(places[:, 0] > 0.3, np.nan, 1.0))
    assert abs(got.mesh.volume - 4 * 1.3) <= got.error


def test_what_is_smaller_than_a_first_cell_is_found_by_random_places() -> None:
    """A ball of 1/600 of the box between all corners of the first lattice, and a hole of that size."""
    small = ball(0.055, (0.0625, 0.0625, 0.0625))  # in the middle of a cell of 0.125
    for body, known in ((small, 4 / 3 * np.pi * 0.055**3), (lambda places: -small(places), None)):
        got = found(body, finest=128)
        true = 8 - 4 / 3 * np.pi * 0.055**3 if known is None else known
        assert got.mesh.volume == pytest.approx(true, abs=got.error)
        assert len(got.mesh.triangles) > 0


def test_missed_volume_is_within_the_reported_error() -> None:
    got = found(ball(0.01, (0.4, 0.3, 0.2)))
    assert got.mesh.volume == 0.0
    assert got.unseen >= 4 / 3 * np.pi * 0.01**3
    assert got.error >= got.unseen


@pytest.mark.parametrize(
    "thin",
    [
        lambda places: np.where(places[:, 1] == 0.0, 1.0, -np.inf),
        lambda places: np.where((places[:, :2] == 0.0).all(axis=1), 1.0, -np.inf),
        lambda places: -np.abs(np.linalg.norm(places, axis=1) - 0.5),
    ],
    ids=["plane", "line", "sphere"],
)
def test_what_has_no_thickness_does_not_converge_and_ends_early(thin: Body) -> None:
    got = found(thin)
    assert got.places < 4_000_000
    assert got.mesh.volume <= got.error
    assert got.converged == (len(got.mesh.triangles) == 0)


def test_a_body_too_small_for_the_random_places_ends_when_its_surface_is_known() -> None:
    """Of 0.026 % of the box: what random places may have missed is more than the tolerance, however fine the cells."""
    got = found(ball(0.08))
    assert not got.converged
    assert abs(got.mesh.volume - 4 / 3 * np.pi * 0.08**3) <= got.error
    assert got.unseen > 2e-3 * got.mesh.volume > 0.0
    assert got.error < 1.1 * got.unseen
    assert got.places < 1_000_000


def test_places_are_capped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refinement, "MAX_PLACES", 300_000)
    got = found(ball(0.8), tolerance=2e-4)
    assert not got.converged
    assert got.places < 330_000
    assert abs(got.mesh.volume - BODIES["ball"][1]) <= got.error


@pytest.mark.parametrize("finest", [2, 10, 40, 100])
def test_finest_cells(finest: int) -> None:
    got = found(ball(0.8), finest=finest)
    assert finest <= max(got.cells) < 2 * finest + 16
    assert abs(got.mesh.volume - BODIES["ball"][1]) <= got.error


def test_a_long_box_has_cells_that_are_nearly_cubes() -> None:
    box = SearchBox(np.array([0.0, 0.0, 0.0]), np.array([1.0, 8.0, 4.0]))
    got = found(lambda places: 0.3 - np.abs(places[:, 0] - 0.5), box)
    assert got.mesh.volume == pytest.approx(0.6 * 32, abs=got.error)
    assert got.cells[1] == 2 * got.cells[2] == 4 * got.cells[0]


def test_a_place_in_the_box_is_requested_and_no_other() -> None:
    box = SearchBox(np.array([0.1, -0.3, 2.0]), np.array([0.7, 0.9, 5.0]))
    asked = []

    def margin(places: np.ndarray, purpose: str) -> np.ndarray:
        asked.append(places)
        return places[:, 2] - 3.0

    got = refine(margin, box, RefinementSettings())
    places = np.concatenate(asked)
    assert got.places == len(places)
    assert (places >= box.low).all()
    assert (places <= box.high).all()
    assert got.mesh.volume == pytest.approx(0.6 * 1.2 * 2.0, rel=1e-3)
