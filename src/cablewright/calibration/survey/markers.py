"""From shots to markers: repeated shots become one place with a covariance, each marker knows what it is on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.survey.plan import SCHEME, Feature, Instrument, SurveyPlan, feature_of
from cablewright.calibration.survey.shots import FARTHEST, Shot, Shots
from cablewright.errors import InputError

MAX_MARKERS: Final = 600  # their covariance is a full matrix
_LARGEST_EXTENT: Final = 500.0  # m, of a machine; farther apart is a unit
_APART: Final = 0.02  # m: shots of one marker that differ by more, and by this many sigma, are not of one marker
_SIGMAS_APART: Final = 6.0
_MIN_SIGMA: Final = 1e-6  # m: no shot is better, so that no weight is infinite


@dataclass(frozen=True, eq=False)
class SurveyMarker:
    """One marker, its shots put together."""

    point: str
    feature: Feature
    lines: tuple[int, ...]  # of the file, one of each shot
    position: Array  # (3,) m, the instrument's grid
    covariance: Array  # (3, 3) m^2
    repeat: float  # m, rms distance of the shots from their mean; NaN for one shot


@dataclass(frozen=True, eq=False)
class Markers:
    """All markers of a survey that are on something."""

    all: tuple[SurveyMarker, ...]
    unknown: tuple[str, ...]  # points that neither their names nor the plan explain
    station: Array | None  # (3,) m, the instrument in its grid, where file or plan say it

    @property
    def covariance(self) -> Array:
        """(3 N, 3 N) m^2 of all coordinates."""
        full = np.zeros((3 * len(self.all), 3 * len(self.all)))
        for i, marker in enumerate(self.all):
            full[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = marker.covariance
        return full

    def on(self, feature: Feature) -> list[int]:
        """Which markers are on a feature, in the order of their names: X3-2 before X3-10."""
        found = [i for i, marker in enumerate(self.all) if marker.feature == feature]
        return sorted(found, key=lambda i: (len(self.all[i].point), self.all[i].point))

    @property
    def features(self) -> list[Feature]:
        """What is marked, each once, in the order of the file."""
        return list(dict.fromkeys(marker.feature for marker in self.all))


def markers_of(found: Shots, plan: SurveyPlan, lines: Sequence[str] | None) -> Markers:
    """Put the shots of each marker together. ``lines`` are the robot's, by name.

    Raises `InputError` if none is on anything, a marker's shots are far apart, or places are no machine's.
    """
    by_point: dict[str, list[Shot]] = {}
    for shot in found.shots:
        by_point.setdefault(shot.point, []).append(shot)
    features = {point: feature_of(point, plan, lines) for point in by_point}
    missing = next((point for point in plan.points if point not in by_point), None)
    if missing is not None:
        raise InputError(f"{found.origin}: no shot of marker {missing!r}, which the plan's points name")
    used = [point for point, feature in features.items() if feature is not None]
    if not used:
        what = f"none of {len(by_point)} points has a marker's name" if by_point else "no shot of a marker"
        raise InputError(f"{found.origin}: {what}; names are like {SCHEME}; or give a plan that says what they are")
    if len(used) > MAX_MARKERS:
        raise InputError(f"{found.origin}: {len(used)} markers, at most {MAX_MARKERS} are allowed")
    markers = tuple(
        _together(point, feature, by_point[point], plan.instrument, found.origin)
        for point, feature in features.items()
        if feature is not None
    )
    _check_extent(markers, found.origin)
    unknown = tuple(p for p, feature in features.items() if feature is None and p not in plan.points)
    return Markers(markers, unknown, _station(found.shots, plan.instrument))


def _station(shots: Sequence[Shot], instrument: Instrument) -> Array | None:
    """Return where the instrument stands. A reflector's height is no part of it."""
    stands = [np.subtract(shot.position, shot.sight) for shot in shots if shot.sight is not None]
    if stands:
        return np.array([*stands[0][:2], max(stand[2] for stand in stands)])
    return None if instrument.station is None else np.array(instrument.station)


def _together(point: str, feature: Feature, shots: list[Shot], instrument: Instrument, origin: str) -> SurveyMarker:
    """Weigh the shots of one marker; the error of where it sits is common to them."""
    places = np.array([shot.position for shot in shots])  # (s, 3)
    own = np.stack([_covariance(shot, instrument, origin) for shot in shots])
    weights = np.linalg.inv(own)
    together = np.linalg.inv(weights.sum(axis=0))
    # From the first, so that a grid's millions of metres do not cost digits.
    mean = places[0] + together @ np.einsum("sij,sj->i", weights, places - places[0])
    off = np.linalg.norm(places - mean, axis=1)
    limit = max(_APART, _SIGMAS_APART * math.sqrt(np.trace(own.max(axis=0))))
    if off.max() > limit:
        far = int(off.argmax())
        where = f"lines {', '.join(str(shot.line) for shot in shots[:8])}"
        raise InputError(
            f"{origin}: marker {point!r} ({where}): the shot at line {shots[far].line} is {off[far]:.3g} m off their "
            f"mean; is it another marker?"
        )
    repeat = float(np.sqrt(np.mean(off**2))) if len(shots) > 1 else math.nan
    covariance = together + instrument.marker**2 * np.eye(3)
    return SurveyMarker(point, feature, tuple(shot.line for shot in shots), mean, covariance, repeat)


def _covariance(shot: Shot, instrument: Instrument, origin: str) -> Array:
    """(3, 3) m^2: along the sight the distance's variance, across it the circles'."""
    sight = np.array(shot.position if shot.sight is None else shot.sight)
    if shot.sight is None:
        sight = sight - np.array(instrument.station or (0.0, 0.0, 0.0))
        if not math.hypot(*sight) <= FARTHEST:
            away = f"{math.hypot(*sight):.6g} m from the instrument"
            raise InputError(
                f"{origin}, line {shot.line}: point {shot.point!r} is {away}; give a unit, as in 'x (mm)', or say in "
                f"the plan where the instrument stands, instrument.station"
            )
    far, level = math.hypot(*sight), math.hypot(*sight[:2])
    u = sight / far if far > 0 else np.array([1.0, 0.0, 0.0])
    across = np.array([-u[1], u[0], 0.0]) * (far / level) if level > 1e-9 * far else np.array([0.0, 1.0, 0.0])
    along = instrument.distance + 1e-6 * instrument.ppm * far
    return (
        along**2 * np.outer(u, u)
        + (instrument.angle * level) ** 2 * np.outer(across, across)
        + (instrument.angle * far) ** 2 * np.outer(np.cross(u, across), np.cross(u, across))
        + _MIN_SIGMA**2 * np.eye(3)
    )


def _check_extent(markers: Sequence[SurveyMarker], origin: str) -> None:
    extent = np.ptp([marker.position for marker in markers], axis=0)
    if extent.max() > _LARGEST_EXTENT:
        axis = "xyz"[int(extent.argmax())]
        what = f"markers are {extent.max():.6g} m apart along {axis}, at most {_LARGEST_EXTENT:g} m are sensible"
        raise InputError(f"{origin}: {what}; are these mm? say so in the header, as in '{axis} (mm)'")
