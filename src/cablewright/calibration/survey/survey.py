"""A total-station survey: exit points, sheave axes and walls from markers (Merlet, Papegay 2023, II.B).

The survey frame has z up and by default its y axis along the west wall; x points from that wall into the room.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.calibration.survey import shape_fits
from cablewright.calibration.survey.frame import SurveyFrame, frame_of
from cablewright.calibration.survey.markers import Markers, markers_of
from cablewright.calibration.survey.plan import MarkedFeature, Placing, SurveyPlan, load_plan
from cablewright.calibration.survey.result import Exit, MarkerResidual, SheaveAxis, Survey, SurveyedWall
from cablewright.calibration.survey.shape_fits import Linear, ShapeFit
from cablewright.calibration.survey.shots import Shots, read_shots
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.units import spell_length
from cablewright.models.statics import Model
from cablewright.robot import Robot

_MAX_AZIMUTH_SIGMA: Final = math.radians(1.0)  # of a wall's normal
_MAX_CENTRE_SIGMA: Final = 0.02  # m, of a circle's centre
_MAX_LEAN_SIGMA: Final = math.radians(0.5)  # of a lean that is reported
_MAX_CHI_SQUARED: Final = 9.0  # per surplus condition, of a leaning wall that is accepted
_FLAT: Final = 1e-3  # min ratio of width to length of the marks on a circle
_BEYOND: Final = 0.02  # m beyond a wall that needs no note: plaster, recesses
_MIN_LEVEL: Final = 0.01  # m: two markers with a smaller horizontal distance give no direction


def survey(
    shots: str | Path | Shots, plan: str | Path | SurveyPlan | None = None, *, robot: Robot | Model | None = None
) -> Survey:
    """Return exit points, sheave axes and walls from *shots*, a total station's measurements of markers or their file.

    *plan*: markers, instrument and frame where they differ from the defaults, or a TOML file. *robot*: the robot whose
    lines the numbers in the markers' names count; without it lines are named by these numbers.

    Raises `InputError` for too few markers, markers nearly in one place or on one line, contradictory names. Source:
    Merlet, Papegay 2023, II.B.

    Examples
    --------
    >>> import cablewright as cw
    >>> places = {"WEST1": (0, 0, 1), "WEST2": (0, 4, 1), "NORTH1": (1, 5, 1), "NORTH2": (3, 5, 1)}
    >>> shots = [cw.Shot(name, row, place) for row, (name, place) in enumerate(places.items())]
    >>> [(wall.name, round(wall.distance, 6)) for wall in cw.survey(cw.Shots(tuple(shots), (), "by hand")).walls]
    [('west', 0.0), ('north', 5.0)]
    """
    shots = shots if isinstance(shots, Shots) else read_shots(shots)
    if not isinstance(plan, SurveyPlan):
        plan = SurveyPlan() if plan is None else load_plan(plan)
    lines = None if robot is None else [line.name for line in Model.of(robot).robot.lines]
    return _Evaluation(shots, plan, lines).run()


class _Evaluation:
    """The evaluation of one survey: fits in the instrument's grid, their residuals and notes."""

    def __init__(self, shots: Shots, plan: SurveyPlan, lines: Sequence[str] | None) -> None:
        self.origin, self.plan = shots.origin, plan
        self.markers: Markers = markers_of(shots, plan, lines)
        self.covariance = self.markers.covariance
        self.fits: dict[MarkedFeature, ShapeFit] = {}
        self.notes = list(shots.notes)
        self.residuals: dict[str, tuple[float, float]] = {}  # m, of each marker, and its expected size
        self.order = list(lines or ())
        known = lines or dict.fromkeys(
            f.name for f in self.markers.features if f.kind not in ("wall", "floor", "ceiling")
        )
        for name in plan.lines:
            if name not in known:
                raise UnknownName("line of the plan", name, known)
        unknown = self.markers.unknown
        if unknown:
            more = f" and {len(unknown) - 8} more" if len(unknown) > 8 else ""
            self.notes.append(f"not named as markers, so left out: {', '.join(unknown[:8])}{more}")

    def run(self) -> Survey:
        """Fit all features, set up the frame and express the features in it."""
        markers = self.markers
        walls = {f: self._wall(f) for f in markers.features if f.kind == "wall"}
        levels = {f: self._level(f) for f in markers.features if f.kind in ("floor", "ceiling")}
        swivels = {f: self._swivel(f) for f in markers.features if f.kind == "axis"}
        sheaves = {f: self._sheave(f) for f in markers.features if f.kind == "sheave"}
        places = dict(self._exits(swivels, sheaves))
        frame = frame_of(self.plan, walls, levels, places, markers, self.origin)
        placed = {feature: frame.put(place) for feature, place in places.items()}
        found = tuple(self._walls(walls, levels, frame))
        rows = tuple(
            MarkerResidual(m.point, m.feature.words, *self.residuals[m.point], m.repeat, len(m.lines))
            for m in markers.all
        )
        checked = np.array([row.residual for row in rows if not math.isnan(row.residual)])
        chi = sum(fit.chi_squared for fit in self.fits.values())
        surplus = sum(fit.surplus for fit in self.fits.values())
        unit_weight = math.sqrt(chi / surplus) if surplus else math.nan
        for row in rows:
            if row.suspect:
                self.notes.append(
                    f"marker {row.point} ({row.feature}) is {1e3 * row.residual:.1f} mm off, {1e3 * row.sigma:.1f} mm "
                    "are expected: measure it again"
                )
        if unit_weight > 2:
            self.notes.append(
                f"markers fit {unit_weight:.1f} times worse than the instrument's stated accuracy explains"
            )
        exits = tuple(self._exit_of(line, placed) for line in self._lines(placed))
        self.notes.extend(_beyond_walls(exits, found))
        return Survey(
            exits=exits,
            axes=tuple(self._axes(swivels, sheaves, frame)),
            walls=found,
            residuals=rows,
            rms=float(np.sqrt(np.mean(checked**2))) if len(checked) else math.nan,
            unit_weight=unit_weight,
            frame=frame,
            covariance=self._joint(placed),
            notes=tuple(self.notes),
        )

    # Fits, in the instrument's grid.

    def _wall(self, feature: MarkedFeature) -> Linear:
        which = self._enough(feature, 2, "the line through them is the wall's direction")
        places, covariances = self._places(which)
        apart = math.hypot(*np.ptp(places[:, :2], axis=0))
        known = "not known"
        if apart >= _MIN_LEVEL:
            fit = shape_fits.upright_plane(places, covariances)
            found = self._kept(feature, which, fit)
            sigma = self._sigma(found[:1])
            if fit.converged and sigma <= _MAX_AZIMUTH_SIGMA:
                return found
            known = f"known to {_deg(sigma)}" if fit.converged else known
        raise InputError(
            f"{self.origin}: {feature.words}: its markers are {apart:.3g} m apart in plan, its direction is {known}; "
            f"{_deg(_MAX_AZIMUTH_SIGMA)} is required"
        )

    def _level(self, feature: MarkedFeature) -> Linear:
        which = self.markers.on(feature)
        return self._kept(feature, which, shape_fits.level_plane(*self._places(which)))

    def _swivel(self, feature: MarkedFeature) -> Linear:
        which = self._marks(feature, slice(0, 2))
        return self._circle(feature, which, shape_fits.level_circle(*self._places(which)), slice(0, 2))

    def _sheave(self, feature: MarkedFeature) -> tuple[Linear, Array]:
        which = self._marks(feature, slice(0, 3))
        fit, basis = shape_fits.circle(*self._places(which))
        return self._circle(feature, which, fit, slice(0, 3)), basis

    def _marks(self, feature: MarkedFeature, axes: slice) -> list[int]:
        """Return the marks of a circle. Raises `InputError` if they lie on one line in these *axes*."""
        which = self._enough(feature, 3, "a circle needs three")
        places = self._places(which)[0][:, axes]
        size = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
        if not size[1] > _FLAT * size[0]:
            raise self._no_circle(feature, which, "not at all")
        return which

    def _circle(self, feature: MarkedFeature, which: list[int], fit: ShapeFit, centre: slice) -> Linear:
        found = self._kept(feature, which, fit)
        sigma = self._sigma(found[centre])
        if not (fit.converged and sigma <= _MAX_CENTRE_SIGMA):
            raise self._no_circle(feature, which, f"to {1e3 * sigma:.0f} mm" if fit.converged else "not at all")
        return found

    def _no_circle(self, feature: MarkedFeature, which: list[int], known: str) -> InputError:
        return InputError(
            f"{self.origin}: {feature.words}: its {len(which)} markers are nearly on one line or in one place: the "
            f"centre of their circle is known {known}, {1e3 * _MAX_CENTRE_SIGMA:.0f} mm is required; turn it farther "
            "between shots"
        )

    def _exits(
        self, swivels: Mapping[MarkedFeature, Linear], sheaves: Mapping[MarkedFeature, tuple[Linear, Array]]
    ) -> Iterator[tuple[MarkedFeature, Linear]]:
        """Yield exit points and winch exit points."""
        for feature in self.markers.features:
            if feature.kind in ("exit", "winch"):
                yield feature, self._placed(feature, self.plan.placing(feature))
        for feature, axis in swivels.items():
            place = MarkedFeature("exit", feature.name)
            if place in self.markers.features:
                raise InputError(
                    f"{self.origin}: line {feature.name} has markers of its exit point and of its swivel axis, "
                    f"{self._names(place)} and {self._names(feature)}; the exit point is found from one of these: call "
                    "the others 'none' in a plan"
                )
            sheave = sheaves.get(MarkedFeature("sheave", feature.name))
            up = axis[[3]] if sheave is None else sheave[0][[2]]
            drop = self.plan.placing(place).offset[2] if sheave is None else 0.0
            value = np.concatenate([axis.value[:2], up.value + drop])
            yield place, Linear(value, np.concatenate([axis.jacobian[:2], up.jacobian]))

    def _placed(self, feature: MarkedFeature, placing: Placing) -> Linear:
        """Return the point that the markers of *feature* surround: their mean plus the offset of *placing*."""
        which = self.markers.on(feature)
        places, _ = self._places(which)
        jacobian = np.zeros((3, len(self.markers.all), 3))
        jacobian[:, which] = np.eye(3)[:, None, :] / len(which)
        value = places.mean(axis=0)
        ahead, left, up = placing.offset
        if (ahead or left or placing.spacing is not None) and len(which) < 2:
            raise InputError(
                f"{self.origin}: {feature.words}: 1 marker, {self._names(feature)}; an offset sideways or a spacing "
                "needs a second marker, which gives the direction"
            )
        if ahead or left:
            way = (places[1] - places[0])[:2]
            level = math.hypot(*way)
            if level < _MIN_LEVEL:
                raise InputError(
                    f"{self.origin}: {feature.words}: its first two markers are {1e3 * level:.3g} mm apart in plan, "
                    "which gives no direction for its offset sideways"
                )
            e = way / level
            f = np.array([-e[1], e[0]])
            value[:2] += ahead * e + left * f
            turn = np.outer(ahead * f - left * e, f) / level  # de = f (f . d) / level, df = -e (f . d) / level
            jacobian[:2, which[1], :2] += turn
            jacobian[:2, which[0], :2] -= turn
        value[2] += up
        if placing.spacing is not None:
            self._check_spacing(which[:2], placing.spacing)
        else:
            self.residuals |= {self.markers.all[i].point: (math.nan, math.nan) for i in which}
        return Linear(value, jacobian.reshape(3, -1))

    def _check_spacing(self, which: list[int], spacing: float) -> None:
        """Compare the distance of two markers with the plan's; the residual of each is half of the difference."""
        places, covariances = self._places(which)
        between = places[1] - places[0]
        found = float(np.linalg.norm(between))
        u = between / max(found, 1e-300)
        sigma = math.sqrt(u @ (covariances[0] + covariances[1]) @ u)
        for i in which:
            self.residuals[self.markers.all[i].point] = 0.5 * abs(found - spacing), 0.5 * sigma

    # Markers of a feature, and the results of its fit.

    def _enough(self, feature: MarkedFeature, minimum: int, why: str) -> list[int]:
        which = self.markers.on(feature)
        if len(which) < minimum:
            raise InputError(
                f"{self.origin}: {feature.words}: {len(which)} marker{'s' * (len(which) > 1)}, {self._names(feature)}; "
                f"{minimum} or more are required: {why}"
            )
        return which

    def _names(self, feature: MarkedFeature) -> str:
        names = [self.markers.all[i].point for i in self.markers.on(feature)]
        return ", ".join(names[:4]) + (", .." if len(names) > 4 else "")

    def _places(self, which: list[int]) -> tuple[Array, Array]:
        chosen = [self.markers.all[i] for i in which]
        return np.array([m.position for m in chosen]), np.array([m.covariance for m in chosen])

    def _linear(self, fit: ShapeFit, which: list[int]) -> Linear:
        jacobian = np.zeros((len(fit.value), len(self.markers.all), 3))
        jacobian[:, which] = fit.jacobian.reshape(len(fit.value), len(which), 3)
        return Linear(fit.value, jacobian.reshape(len(fit.value), -1))

    def _sigma(self, found: Linear) -> float:
        return float(found.sigma(self.covariance).max())

    def _kept(self, feature: MarkedFeature, which: list[int], fit: ShapeFit) -> Linear:
        """Keep a fit, and the residuals of its markers."""
        self.fits[feature] = fit
        for i, off, allowed in zip(which, fit.residuals, fit.allowed, strict=True):
            checked = fit.surplus > 0 and bool(np.any(allowed > 0))
            size = (float(np.linalg.norm(off)), float(np.linalg.norm(allowed))) if checked else (math.nan, math.nan)
            self.residuals[self.markers.all[i].point] = size
        return self._linear(fit, which)

    # The parts of the result, in its frame.

    def _lines(self, places: Mapping[MarkedFeature, Linear]) -> list[str]:
        names = list(dict.fromkeys(feature.name for feature in places))
        return sorted(names, key=lambda n: (self.order.index(n) if n in self.order else len(n), n))

    def _exit_of(self, line: str, placed: Mapping[MarkedFeature, Linear]) -> Exit:
        both = [placed.get(MarkedFeature("exit", line)), placed.get(MarkedFeature("winch", line))]
        values = [None if place is None else place.value for place in both]
        sigmas = [None if place is None else place.sigma(self.covariance) for place in both]
        return Exit(line, *values, *sigmas)

    def _joint(self, placed: Mapping[MarkedFeature, Linear]) -> Array:
        """Return the covariance of all exit points and winch exit points, line by line."""
        parts = [
            placed[f].jacobian
            for line in self._lines(placed)
            for f in (MarkedFeature("exit", line), MarkedFeature("winch", line))
            if f in placed
        ]
        jacobian = np.concatenate([np.zeros((0, len(self.covariance))), *parts])
        return np.asarray(jacobian @ self.covariance @ jacobian.T)

    def _axes(
        self,
        swivels: Mapping[MarkedFeature, Linear],
        sheaves: Mapping[MarkedFeature, tuple[Linear, Array]],
        frame: SurveyFrame,
    ) -> Iterator[SheaveAxis]:
        for feature, found in swivels.items():
            yield self._axis(feature, "swivel", frame.put(found[[0, 1, 3]]), np.array([0.0, 0.0, 1.0]), found[[2]])
        for feature, (found, basis) in sheaves.items():
            direction = frame.rotation @ (found.value[4:] @ basis[:2] + basis[2])
            direction *= np.sign(direction[np.abs(direction).argmax()]) / np.linalg.norm(direction)
            yield self._axis(feature, "sheave", frame.put(found[:3]), direction, found[[3]])

    def _axis(self, feature: MarkedFeature, kind: str, centre: Linear, direction: Array, radius: Linear) -> SheaveAxis:
        places = self._places(self.markers.on(feature))[0]
        fitted = self.fits[feature].value[[0, 1, 3] if kind == "swivel" else [0, 1, 2]]  # the centre, in the grid
        length, sigma = float(radius.value[0]), self._sigma(radius)
        around = _arc(places - fitted)
        return SheaveAxis(
            feature.name, kind, centre.value, direction, length, centre.sigma(self.covariance), sigma, around
        )

    def _walls(
        self, walls: Mapping[MarkedFeature, Linear], levels: Mapping[MarkedFeature, Linear], frame: SurveyFrame
    ) -> Iterator[SurveyedWall]:
        for feature, found in walls.items():
            normal, distance, azimuth = frame.wall(feature, found)
            lean = self._lean(feature, float(found.value[0]), frame.outward[feature])
            sigmas = self._sigma(azimuth), self._sigma(distance)
            yield SurveyedWall(
                feature.name, normal, float(distance.value[0]), *sigmas, *lean, *self._rms_and_count(feature)
            )
        for feature, found in levels.items():
            height, sign = frame.height(found), -1.0 if feature.kind == "floor" else 1.0
            level = sign * float(height.value[0]) + 0.0  # + 0.0: no minus zero for the floor that is the origin
            sigmas, normal = (0.0, self._sigma(height)), np.array([0.0, 0.0, sign])
            yield SurveyedWall(feature.kind, normal, level, *sigmas, math.nan, math.nan, *self._rms_and_count(feature))

    def _rms_and_count(self, feature: MarkedFeature) -> tuple[float, int]:
        fit = self.fits[feature]
        rms = float(np.sqrt(np.mean(fit.residuals**2))) if fit.surplus > 0 else math.nan
        return rms, len(self.markers.on(feature))

    def _lean(self, feature: MarkedFeature, azimuth: float, outward: float) -> tuple[float, float]:
        """Return the angle by which a wall leans out at its top, rad, and its sigma; NaN if the markers leave it open.

        Adds a note where the wall leans by more than three sigma.
        """
        which = self.markers.on(feature)
        if len(which) < 3:
            return math.nan, math.nan
        fit = shape_fits.plane(*self._places(which), azimuth)
        sigma = self._sigma(self._linear(fit, which)[[1]])
        if not fit.converged or not 0 < sigma <= _MAX_LEAN_SIGMA:
            return math.nan, math.nan
        lean = -outward * float(fit.value[1])  # a wall whose normal points down leans out
        if abs(lean) > 3 * sigma:
            note = f"{feature.words} leans {'out' if lean > 0 else 'in'} at its top by {_deg(abs(lean))}"
            if fit.surplus and fit.chi_squared < _MAX_CHI_SQUARED * fit.surplus:
                self._kept(feature, which, fit)  # residuals of its markers are those from the leaning wall
                self.notes.append(f"{note}: its distance is that at the mean height of its markers")
            else:
                self.notes.append(f"{note}, or one of its {len(which)} markers is wrong")
        return lean, sigma


def _beyond_walls(exits: Sequence[Exit], walls: Sequence[SurveyedWall]) -> Iterator[str]:
    """Yield a note for each exit point or winch exit beyond a plane of the room by more than its sigmas explain."""
    for each in exits:
        for what, place, sigma in (
            ("exit point", each.exit_point, each.exit_sigma), ("winch exit", each.winch_exit, each.winch_sigma)
        ):  # fmt: skip
            if place is None or sigma is None or not walls:
                continue
            wall = max(walls, key=lambda wall: float(wall.normal @ place) - wall.distance)
            beyond = float(wall.normal @ place) - wall.distance
            if beyond > _BEYOND + 3.0 * math.hypot(wall.distance_sigma, *sigma):
                yield (
                    f"the {what} of line {each.line} is {spell_length(beyond)} beyond {wall.words}: measured from "
                    "another station, or a wrong name?"
                )


def _arc(away: Array) -> float:
    """Return the arc (rad) that points span about a centre, given relative to it: a full turn less the largest gap."""
    _, _, axes = np.linalg.svd(away, full_matrices=False)
    angles = np.sort(np.arctan2(away @ axes[1], away @ axes[0]))
    return float(math.tau - np.diff(np.append(angles, angles[0] + math.tau)).max())


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.2g} deg"
