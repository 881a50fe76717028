"""Surveyed markers: the repeated shots of each become one position with a covariance, on a known feature."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg import block_diag

from cablewright.calibration.survey.plan import SCHEME, Instrument, MarkedFeature, SurveyPlan, feature_of
from cablewright.calibration.survey.shots import FARTHEST, Shot, Shots
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError

MAX_MARKERS: Final = 600  # their covariance is a full matrix
_MAX_EXTENT: Final = 500.0  # m, of all markers; a larger number is in the wrong unit
_APART: Final = 0.02  # m: shots that differ by more, and by this many sigma, are not of one marker
_SIGMAS_APART: Final = 6.0
_MIN_SIGMA: Final = 1e-6  # m, of a shot, so that no weight is infinite


@dataclass(frozen=True, eq=False)
class SurveyMarker:
    """One surveyed marker: the weighted mean of its shots."""

    point: str
    feature: MarkedFeature
    lines: tuple[int, ...]  # of the file, one for each shot
    position: Array  # (3,) m, in the instrument's grid
    covariance: Array  # (3, 3) m^2
    repeat: float  # m, rms distance of the shots from their mean; NaN for one shot


@dataclass(frozen=True, eq=False)
class Markers:
    """All markers of a survey that are on a known feature."""

    all: tuple[SurveyMarker, ...]
    unknown: tuple[str, ...]  # points whose feature neither their names nor the plan give
    station: Array | None  # (3,) m, the instrument in its grid; None if neither file nor plan gives it

    @property
    def covariance(self) -> Array:
        """Covariance (3 N, 3 N), m^2, of the coordinates of all markers."""
        return np.asarray(block_diag(*(marker.covariance for marker in self.all)))

    def on(self, feature: MarkedFeature) -> list[int]:
        """Return the indices of the markers on a feature, in the order of their names: X3-2 before X3-10."""
        found = [i for i, marker in enumerate(self.all) if marker.feature == feature]
        return sorted(found, key=lambda i: (len(self.all[i].point), self.all[i].point))

    @property
    def features(self) -> list[MarkedFeature]:
        """The marked features, each once, in the order of the file."""
        return list(dict.fromkeys(marker.feature for marker in self.all))


def markers_of(found: Shots, plan: SurveyPlan, lines: Sequence[str] | None) -> Markers:
    """Return the markers of all shots. ``lines``: the names of the robot's lines, None without a robot.

    Raises `InputError` if no marker is on a known feature, shots of a marker are far apart, or the markers extend over
    more than any machine.
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
        left_out = next((note for note in found.notes if "left out" in note and not by_point), "")
        why = left_out or f"expected names are {SCHEME}; or give a plan with [points]"
        raise InputError(f"{found.origin}: {what}; {why}")
    if len(used) > MAX_MARKERS:
        raise InputError(f"{found.origin}: {len(used)} markers, over the limit of {MAX_MARKERS}")
    markers = tuple(
        _together(point, feature, by_point[point], plan.instrument, found.origin)
        for point, feature in features.items()
        if feature is not None
    )
    _check_extent(markers, found.origin)
    unknown = tuple(p for p, feature in features.items() if feature is None and p not in plan.points)
    return Markers(markers, unknown, _station(found.shots, plan.instrument))


def _station(shots: Sequence[Shot], instrument: Instrument) -> Array | None:
    """Return the position of the instrument: the highest one, where several are given."""
    sights = [(s.position, s.sight, (0.0, 0.0, s.reflector)) for s in shots if s.sight is not None]
    stands = [np.add(np.subtract(position, sight), raised) for position, sight, raised in sights]
    if stands:
        return np.array([*stands[0][:2], max(stand[2] for stand in stands)])
    return None if instrument.station is None else np.array(instrument.station)


def _together(
    point: str, feature: MarkedFeature, shots: list[Shot], instrument: Instrument, origin: str
) -> SurveyMarker:
    """Return the weighted mean of the shots of one marker; the error of the marker's own place is common to them."""
    places = np.array([shot.position for shot in shots])  # (s, 3)
    own = np.stack([_covariance(shot, instrument, origin) for shot in shots])
    weights = np.linalg.inv(own)
    together = np.linalg.inv(weights.sum(axis=0))
    # Relative to the first shot: coordinates of a national grid, millions of metres, would cost digits.
    mean = places[0] + together @ np.einsum("sij,sj->i", weights, places - places[0])
    off = np.linalg.norm(places - mean, axis=1)
    limit = max(_APART, _SIGMAS_APART * math.sqrt(np.trace(own.max(axis=0))))
    if off.max() > limit:
        far = int(off.argmax())
        raise InputError(
            f"{origin}: marker {point!r} (lines {', '.join(str(shot.line) for shot in shots[:8])}): the shot at line "
            f"{shots[far].line} is {off[far]:.3g} m off their mean; is it another marker?"
        )
    repeat = float(np.sqrt(np.mean(off**2))) if len(shots) > 1 else math.nan
    covariance = together + instrument.marker**2 * np.eye(3)
    return SurveyMarker(point, feature, tuple(shot.line for shot in shots), mean, covariance, repeat)


def _covariance(shot: Shot, instrument: Instrument, origin: str) -> Array:
    """Return the covariance (3, 3) of a shot, m^2: of the distance along the sight, of both circles across it."""
    sight = np.array(shot.position if shot.sight is None else shot.sight)
    if shot.sight is None:
        sight = sight - np.array(instrument.station or (0.0, 0.0, 0.0))
        if not math.hypot(*sight) <= FARTHEST:
            raise InputError(
                f"{origin}, line {shot.line}: point {shot.point!r} is {math.hypot(*sight):.6g} m from the instrument; "
                "give a unit, as in 'x (mm)', or the instrument's position, instrument.station in the plan"
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
    if extent.max() > _MAX_EXTENT:
        axis = "xyz"[int(extent.argmax())]
        raise InputError(
            f"{origin}: markers are {extent.max():.6g} m apart along {axis}, over the limit of {_MAX_EXTENT:g} m; are "
            f"these mm? then name the column '{axis} (mm)'"
        )
