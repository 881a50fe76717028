"""A survey with a total station: winch exits, sheave axes and wall planes from markers (Merlet, Papegay 2023, II.B).

The answer's frame has z up and its y axis along the west wall; x goes from that wall into the room.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.survey import shape_fits
from cablewright.calibration.survey.frame import SurveyFrame, frame_of
from cablewright.calibration.survey.markers import Markers, SurveyMarker, markers_of
from cablewright.calibration.survey.plan import Feature, Placing, SurveyPlan, load_plan
from cablewright.calibration.survey.result import Axis, Exit, MarkerResidual, Survey, SurveyedWall
from cablewright.calibration.survey.shape_fits import Linear, ShapeFit
from cablewright.calibration.survey.shots import Shots, read_shots
from cablewright.errors import InputError, UnknownName
from cablewright.models.statics import Model
from cablewright.robot import Robot

_WORST_AZIMUTH: Final = math.radians(1.0)  # sigma of a wall's direction
_WORST_CENTRE: Final = 0.02  # m, sigma of a circle's centre
_LEAN_KNOWN: Final = math.radians(0.5)  # sigma of a lean that is worth telling
_LIKELY: Final = 9.0  # chi-squared per surplus condition of a fit that is believed
_FLAT: Final = 1e-3  # how much flatter than long a set of marks on a circle may be
_MIN_LEVEL: Final = 0.01  # m: two markers nearer than this in plan give no direction


def survey(
    shots: str | Path | Shots, plan: str | Path | SurveyPlan | None = None, *, robot: Robot | Model | None = None
) -> Survey:
    """Exits, sheave axes and walls from a total station's *shots* at markers, or the file that has them.

    *plan*: markers, instrument and frame where they differ from what is usual, or the TOML that says so. *robot*: whose
    lines the markers' numbers count; without it lines are called by their numbers.

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
    return _Work(shots, plan, lines).done()


class _Work:
    """One survey under way."""

    def __init__(self, shots: Shots, plan: SurveyPlan, lines: Sequence[str] | None) -> None:
        self.shots, self.plan = shots, plan
        self.markers: Markers = markers_of(shots, plan, lines)
        self.covariance = self.markers.covariance
        self.fits: dict[Feature, ShapeFit] = {}
        self.notes = list(shots.notes)
        self.residuals: dict[str, tuple[float, float]] = {}
        self.order = list(lines) if lines is not None else []
        known = lines or dict.fromkeys(
            f.name for f in self.markers.features if f.kind not in ("wall", "floor", "ceiling")
        )
        for name in plan.lines:
            if name not in known:
                raise UnknownName("line of the plan", name, known)

    def done(self) -> Survey:
        """Run all steps."""
        markers = self.markers
        walls = {f: self._wall(f) for f in markers.features if f.kind == "wall"}
        levels = {f: self._level(f) for f in markers.features if f.kind in ("floor", "ceiling")}
        swivels = {f: self._swivel(f) for f in markers.features if f.kind == "axis"}
        sheaves = {f: self._sheave(f) for f in markers.features if f.kind == "sheave"}
        places = dict(self._exits(swivels, sheaves))
        # The instrument stands in the room; else most markers are not on the wall that is asked about.
        everywhere = [marker.position for marker in markers.all]
        inside = np.median(everywhere, axis=0) if markers.station is None else markers.station
        frame = frame_of(self.plan, walls, levels, places, inside, markers, self.shots.origin)
        placed = {feature: frame.put(place) for feature, place in places.items()}
        self._tell()
        found = tuple(self._walls(walls, levels, frame))
        rows = tuple(self._residual_of(marker) for marker in markers.all)
        checked = np.array([row.residual for row in rows if not math.isnan(row.residual)])
        chi = sum(fit.chi_squared for fit in self.fits.values())
        surplus = sum(fit.surplus for fit in self.fits.values())
        self._judge(rows, math.sqrt(chi / surplus) if surplus else math.nan)
        return Survey(
            exits=tuple(self._exit_of(line, placed) for line in self._lines(places)),
            axes=tuple(self._axes(swivels, sheaves, frame)),
            walls=found,
            residuals=rows,
            rms=float(np.sqrt(np.mean(checked**2))) if len(checked) else math.nan,
            unit_weight=math.sqrt(chi / surplus) if surplus else math.nan,
            frame=frame,
            covariance=self._joint(placed),
            notes=tuple(self.notes),
        )

    # What is fitted, in the instrument's grid.

    def _wall(self, feature: Feature) -> Linear:
        which = self._enough(feature, 2, "their line is the wall's direction")
        places, covariances = self._places(which)
        apart = math.hypot(*np.ptp(places[:, :2], axis=0))
        if apart < _MIN_LEVEL:
            raise self._no_wall(feature, apart, "not known")
        fit = shape_fits.upright_plane(places, covariances)
        self._keep(feature, which, fit)
        found = self._linear(fit, which)
        sigma = float(found[:1].sigma(self.covariance)[0])
        if not (fit.converged and sigma <= _WORST_AZIMUTH):
            raise self._no_wall(feature, apart, f"known to {_deg(sigma)}" if fit.converged else "not known")
        return found

    def _no_wall(self, feature: Feature, apart: float, known: str) -> InputError:
        why = f"its markers are {apart:.3g} m apart in plan, its direction is {known}"
        return InputError(f"{self.shots.origin}: {feature.words}: {why}; {_deg(_WORST_AZIMUTH)} is wanted")

    def _level(self, feature: Feature) -> Linear:
        which = self.markers.on(feature)
        fit = shape_fits.level_plane(*self._places(which))
        self._keep(feature, which, fit)
        return self._linear(fit, which)

    def _swivel(self, feature: Feature) -> Linear:
        which = self._round(feature, slice(0, 2))
        return self._circle(feature, which, shape_fits.level_circle(*self._places(which)), slice(0, 2))

    def _sheave(self, feature: Feature) -> tuple[Linear, Array]:
        which = self._round(feature, slice(0, 3))
        fit, basis = shape_fits.circle(*self._places(which))
        return self._circle(feature, which, fit, slice(0, 3)), basis

    def _round(self, feature: Feature, axes: slice) -> list[int]:
        """Return the marks of a circle, which must not all lie on one line."""
        which = self._enough(feature, 3, "a circle goes through three")
        places = self._places(which)[0][:, axes]
        size = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
        if not size[1] > _FLAT * size[0]:
            raise self._no_circle(feature, which, "not at all")
        return which

    def _circle(self, feature: Feature, which: list[int], fit: ShapeFit, centre: slice) -> Linear:
        self._keep(feature, which, fit)
        found = self._linear(fit, which)
        sigma = float(found[centre].sigma(self.covariance).max())
        if not (fit.converged and sigma <= _WORST_CENTRE):
            raise self._no_circle(feature, which, f"to {1e3 * sigma:.0f} mm" if fit.converged else "not at all")
        return found

    def _no_circle(self, feature: Feature, which: list[int], known: str) -> InputError:
        where = f"its {len(which)} markers are nearly on one line or in one place"
        return InputError(
            f"{self.shots.origin}: {feature.words}: {where}: the centre of their circle is known {known}, "
            f"{1e3 * _WORST_CENTRE:.0f} mm is wanted; turn it farther between shots"
        )

    def _exits(
        self, swivels: Mapping[Feature, Linear], sheaves: Mapping[Feature, tuple[Linear, Array]]
    ) -> Iterator[tuple[Feature, Linear]]:
        """Yield exit points and winch exits."""
        for feature in self.markers.features:
            if feature.kind in ("exit", "winch"):
                yield feature, self._placed(feature, self.plan.placing(feature))
        for feature, axis in swivels.items():
            place = Feature("exit", feature.name)
            if place in self.markers.features:
                both = f"{self._names(place)} and {self._names(feature)}"
                raise InputError(
                    f"{self.shots.origin}: line {feature.name} has markers of its exit point and of its swivel axis, "
                    f"{both}; the exit is found from one of these: call the others 'none' in a plan"
                )
            sheave = sheaves.get(Feature("sheave", feature.name))
            up = axis[[3]] if sheave is None else sheave[0][[2]]
            drop = self.plan.placing(place).offset[2] if sheave is None else 0.0
            value = np.concatenate([axis.value[:2], up.value + drop])
            yield place, Linear(value, np.concatenate([axis.motion[:2], up.motion]))

    def _placed(self, feature: Feature, placing: Placing) -> Linear:
        """Find a point from the markers about it."""
        which = self.markers.on(feature)
        places, _ = self._places(which)
        N = len(self.markers.all)
        motion = np.zeros((3, N, 3))
        motion[:, which] = np.eye(3)[:, None, :] / len(which)
        value = places.mean(axis=0)
        ahead, left, up = placing.offset
        if (ahead or left or placing.spacing is not None) and len(which) < 2:
            why = "an offset sideways or a spacing needs a second marker, which gives the direction"
            raise InputError(
                f"{self.shots.origin}: {feature.words}: 1 marker, {self.markers.all[which[0]].point}; {why}"
            )
        if ahead or left:
            way = (places[1] - places[0])[:2]
            level = math.hypot(*way)
            if level < _MIN_LEVEL:
                why = f"its first two markers are {1e3 * level:.3g} mm apart in plan, which gives no direction"
                raise InputError(f"{self.shots.origin}: {feature.words}: {why} for its offset sideways")
            e = way / level
            f = np.array([-e[1], e[0]])
            value[:2] += ahead * e + left * f
            turn = np.outer(ahead * f - left * e, f) / level  # de = f (f . d) / level, df = -e (f . d) / level
            motion[:2, which[1], :2] += turn
            motion[:2, which[0], :2] -= turn
        value[2] += up
        if placing.spacing is not None:
            self._check_spacing(which[:2], placing.spacing)
        else:
            self.residuals |= {self.markers.all[i].point: (math.nan, math.nan) for i in which}
        return Linear(value, motion.reshape(3, -1))

    def _check_spacing(self, which: list[int], spacing: float) -> None:
        """Compare the distance of two markers with what the plan says; half of what is missing is each one's."""
        places, covariances = self._places(which)
        between = places[1] - places[0]
        found = float(np.linalg.norm(between))
        u = between / max(found, 1e-300)
        sigma = math.sqrt(u @ (covariances[0] + covariances[1]) @ u)
        for i in which:
            self.residuals[self.markers.all[i].point] = 0.5 * abs(found - spacing), 0.5 * sigma

    # How the parts are kept and told.

    def _enough(self, feature: Feature, minimum: int, why: str) -> list[int]:
        which = self.markers.on(feature)
        if len(which) < minimum:
            got = f"{len(which)} marker{'s' * (len(which) > 1)}, {self._names(feature)}"
            raise InputError(f"{self.shots.origin}: {feature.words}: {got}; {minimum} or more are wanted: {why}")
        return which

    def _names(self, feature: Feature) -> str:
        names = [self.markers.all[i].point for i in self.markers.on(feature)]
        return ", ".join(names[:4]) + (", .." if len(names) > 4 else "")

    def _places(self, which: list[int]) -> tuple[Array, Array]:
        chosen = [self.markers.all[i] for i in which]
        return np.array([m.position for m in chosen]), np.array([m.covariance for m in chosen])

    def _linear(self, fit: ShapeFit, which: list[int]) -> Linear:
        motion = np.zeros((len(fit.value), len(self.markers.all), 3))
        motion[:, which] = fit.gain.reshape(len(fit.value), len(which), 3)
        return Linear(fit.value, motion.reshape(len(fit.value), -1))

    def _keep(self, feature: Feature, which: list[int], fit: ShapeFit) -> None:
        self.fits[feature] = fit
        for i, off, allowed in zip(which, fit.residuals, fit.allowed, strict=True):
            checked = fit.surplus > 0 and bool(np.any(allowed > 0))
            size = (float(np.linalg.norm(off)), float(np.linalg.norm(allowed))) if checked else (math.nan, math.nan)
            self.residuals[self.markers.all[i].point] = size

    def _residual_of(self, marker: SurveyMarker) -> MarkerResidual:
        size, allowed = self.residuals[marker.point]
        return MarkerResidual(marker.point, marker.feature.words, size, allowed, marker.repeat, len(marker.lines))

    def _lines(self, places: Mapping[Feature, Linear]) -> list[str]:
        names = list(dict.fromkeys(feature.name for feature in places))
        return sorted(names, key=lambda n: (self.order.index(n) if n in self.order else len(n), n))

    def _exit_of(self, line: str, placed: Mapping[Feature, Linear]) -> Exit:
        both = [placed.get(Feature("exit", line)), placed.get(Feature("winch", line))]
        values = [None if place is None else place.value for place in both]
        sigmas = [None if place is None else place.sigma(self.covariance) for place in both]
        return Exit(line, *values, *sigmas)

    def _joint(self, placed: Mapping[Feature, Linear]) -> Array:
        parts = [
            placed[f].motion
            for line in self._lines(placed)
            for f in (Feature("exit", line), Feature("winch", line))
            if f in placed
        ]
        motion = np.concatenate(parts) if parts else np.zeros((0, len(self.covariance)))
        return motion @ self.covariance @ motion.T

    def _axes(
        self, swivels: Mapping[Feature, Linear], sheaves: Mapping[Feature, tuple[Linear, Array]], frame: SurveyFrame
    ) -> Iterator[Axis]:
        up = np.array([0.0, 0.0, 1.0])
        for feature, found in swivels.items():
            centre = frame.put(found[[0, 1, 3]])
            yield self._axis(feature, "swivel", centre, up, found[[2]])
        for feature, (found, basis) in sheaves.items():
            direction = frame.rotation @ (found.value[4:] @ basis[:2] + basis[2])
            direction *= np.sign(direction[np.abs(direction).argmax()]) / np.linalg.norm(direction)
            yield self._axis(feature, "sheave", frame.put(found[:3]), direction, found[[3]])

    def _axis(self, feature: Feature, kind: str, centre: Linear, direction: Array, radius: Linear) -> Axis:
        places = self._places(self.markers.on(feature))[0]
        own = self.fits[feature].value
        middle = np.array([own[0], own[1], own[3]]) if kind == "swivel" else own[:3]
        return Axis(
            feature.name,
            kind,
            centre.value,
            direction,
            float(radius.value[0]),
            centre.sigma(self.covariance),
            float(radius.sigma(self.covariance)[0]),
            _arc(places - middle),
        )

    def _walls(
        self, walls: Mapping[Feature, Linear], levels: Mapping[Feature, Linear], frame: SurveyFrame
    ) -> Iterator[SurveyedWall]:
        for feature, found in walls.items():
            normal, distance, azimuth = frame.wall(feature, found)
            lean, lean_sigma = self._lean(feature, float(found.value[0]), frame.outward[feature])
            yield SurveyedWall(
                feature.name,
                normal,
                float(distance.value[0]),
                float(azimuth.sigma(self.covariance)[0]),
                float(distance.sigma(self.covariance)[0]),
                lean,
                lean_sigma,
                self._rms(feature),
                len(self.markers.on(feature)),
            )
        for feature, found in levels.items():
            height, sign = frame.height(found), -1.0 if feature.kind == "floor" else 1.0
            sigma = float(height.sigma(self.covariance)[0])
            normal, points = np.array([0.0, 0.0, sign]), len(self.markers.on(feature))
            # + 0.0: no minus zero for the floor that is the origin
            yield SurveyedWall(
                feature.kind, normal, sign * float(height.value[0]) + 0.0, 0.0, sigma, math.nan, math.nan,
                self._rms(feature), points,
            )  # fmt: skip

    def _rms(self, feature: Feature) -> float:
        fit = self.fits[feature]
        return float(np.sqrt(np.mean(fit.residuals**2))) if fit.surplus > 0 else math.nan

    def _lean(self, feature: Feature, azimuth: float, outward: float) -> tuple[float, float]:
        """Return how far a wall leans out at its top and the sigma of that; NaN where its markers cannot tell."""
        which = self.markers.on(feature)
        if len(which) < 3:
            return math.nan, math.nan
        fit = shape_fits.plane(*self._places(which), azimuth)
        sigma = float(self._linear(fit, which)[[1]].sigma(self.covariance)[0])
        if not fit.converged or not 0 < sigma <= _LEAN_KNOWN:
            return math.nan, math.nan
        lean = -outward * float(fit.value[1])  # a normal that points down has its wall lean out
        if abs(lean) > 3 * sigma:
            told = f"{feature.words} leans {'out' if lean > 0 else 'in'} at its top by {_deg(abs(lean))}"
            if fit.surplus and fit.chi_squared < _LIKELY * fit.surplus:
                self._keep(feature, which, fit)  # its markers are judged by the wall as it is
                self.notes.append(f"{told}: its distance is that in the middle of its markers' heights")
            else:
                self.notes.append(f"{told}, or one of its {len(which)} markers is wrong")
        return lean, sigma

    def _tell(self) -> None:
        unknown = self.markers.unknown
        if unknown:
            more = f" and {len(unknown) - 8} more" if len(unknown) > 8 else ""
            self.notes.append(f"not markers of anything, so left out: {', '.join(unknown[:8])}{more}")

    def _judge(self, rows: Sequence[MarkerResidual], unit_weight: float) -> None:
        for row in rows:
            if row.suspect:
                off = f"{1e3 * row.residual:.1f} mm off, {1e3 * row.sigma:.1f} mm are expected"
                self.notes.append(f"marker {row.point} ({row.feature}) is {off}: measure it again")
        if unit_weight > 2:
            self.notes.append(
                f"markers fit {unit_weight:.1f} times worse than the instrument's stated accuracy explains"
            )


def _arc(away: Array) -> float:
    """Return the arc that points about a centre span: a turn less the largest gap."""
    _, _, axes = np.linalg.svd(away, full_matrices=False)
    angles = np.sort(np.arctan2(away @ axes[1], away @ axes[0]))
    gaps = np.diff(np.append(angles, angles[0] + math.tau))
    return float(math.tau - gaps.max())


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.2g} deg"
