"""Unknown constants of the machine that the filter estimates, and their effect on the lengths of its lines.

Of each line: error of its home length, share of its drum's radius, error of its exit point, gain and zero of its load
cell, friction of its sheave, zero of its swivel, creep, compliance of the mount of its exit point. Of all: rotation of
the inertial unit, and a wrench for a platform of another mass and centre. All are constant, so that the filter has no
motion to predict: the pose is that of the equilibrium of the corrected lengths. What creep does to a length grows with
the memory of its loads. Only the length by which cable lies unevenly on a drum changes, with the cable that is wound,
and the strain by hysteresis, with the load.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Final

import numpy as np

from cablewright.estimation.body.creep import UNSURE
from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.updates.update import Update
from cablewright.foundation.arrays import Array

_COMPLIANCE: Final = 1e-6  # m/N, of a mount that no file describes, assumed: that of the severity `typical`
_SAME_CABLE: Final = 0.9  # assumed: correlation of the errors of creep of two lines of one kind of cable ...
_SAME_FRAME: Final = 0.5  # ... of two mounts, and of the hysteresis of two lines with load changes of one sign


class BodyLayout:
    """Positions (slices) of the unknowns in the state vector, for *m* lines.

    ``own``: slices of further sensors, by their updates.
    """

    def __init__(self, m: int, sensors: Iterable[Update] = ()) -> None:
        """Home lengths first, radii, exit points by line, uneven lengths, gains, zeros, friction, tilt, load, swivels.

        Then hysteresis and creep. What softens lines comes then, softness of cables and mounts: that is in the
        equilibrium, and no part of the lengths. Unknowns of further *sensors* come last.
        """
        further = [sensor for sensor in sensors if sensor.UNKNOWNS]
        counts = [0, m, m, 3 * m, m, m, m, m, 2, 6, m, m, m, m, m, *(sensor.UNKNOWNS for sensor in further)]
        bounds = np.cumsum(counts).tolist()
        parts = [slice(low, high) for low, high in pairwise(bounds)]
        self.home, self.radius, self.exit, self.uneven, self.gain, self.zero, self.friction = parts[:7]
        self.tilt, self.load, self.swivel, self.hysteresis, self.creep, self.softness, self.mount = parts[7:14]
        self.own = {type(sensor): part for sensor, part in zip(further, parts[14:], strict=True)}
        self.laws = slice(self.creep.start, self.mount.stop)
        self.m, self.size = m, bounds[-1]


def prior(settings: BodySettings, layout: BodyLayout) -> Array:
    """Return the covariance (size, size) of the unknowns before any measurement.

    The compliance of mounts is uncertain by `UNSURE` of that of the robot file, or by 1 um/N, unless specified.
    """
    told, platform = settings.deviations, settings.model.robot.platform
    weight = platform.mass * settings.model.robot.scene.gravity
    variances = np.zeros(layout.size)
    variances[layout.home] = told.home_length**2
    variances[layout.radius] = told.drum_radius**2
    variances[layout.exit] = told.exit_point**2
    variances[layout.uneven] = told.uneven**2
    for sensor in settings.sensors:
        sensor.set_prior(settings, layout, variances)
    variances[layout.load] = np.array([0.0, 0.0, told.mass, told.centre, told.centre, 0.0]) ** 2 * weight**2
    variances[layout.creep] = 1.0
    variances[layout.softness] = told.loop**2  # as wide as the loop after a change by the mean load
    given = settings.model.lines.mount[:, 0]
    assumed = np.where(given > 0.0, UNSURE * given, _COMPLIANCE)
    variances[layout.mount] = assumed**2 if told.exit_compliance is None else told.exit_compliance**2
    covariance = np.diag(variances)
    for part, alike in ((layout.creep, _SAME_CABLE), (layout.softness, _SAME_CABLE), (layout.mount, _SAME_FRAME)):
        sigmas = np.sqrt(variances[part])
        covariance[part, part] = np.outer(sigmas, sigmas) * (alike + (1.0 - alike) * np.eye(layout.m))
    return covariance


def length_gradients(
    layout: BodyLayout,
    paid: Array,
    toward: Array,
    toward_home: Array,
    lengths: Array,
    crept: Array,
    changed: Array,
    given: Array,
) -> Array:
    """Return the derivatives of the lengths by the unknowns: (m, size), m per unit.

    *paid* (m,): m of cable since home. *toward*, *toward_home* (m, 3): directions of the lines now and at home, where
    an exit point's error was part of the home length. *lengths* (m,): m, now. *crept* (m,): strain by one standard
    deviation of creep. *changed* (m,): change of each load since home over their mean there. *given* (m,), N: at which
    a softer mount moves the platform as additional length would.
    """
    m = layout.m
    found, lines = np.zeros((m, layout.size)), np.arange(m)
    found[lines, lines] = 1.0
    found[lines, layout.radius.start + lines] = paid
    found[lines, layout.uneven.start + lines] = 1.0
    columns = layout.exit.start + 3 * lines[:, None] + np.arange(3)
    found[lines[:, None], columns] = toward - toward_home
    found[lines, layout.creep.start + lines] = lengths * crept
    found[lines, layout.softness.start + lines] = lengths * changed
    found[lines, layout.hysteresis.start + lines] = lengths
    found[lines, layout.mount.start + lines] = given
    return found


def wind(settings: BodySettings, layout: BodyLayout, unknowns: Array, covariance: Array, wound: Array) -> None:
    """Update the unknown uneven winding for the cable (m,), m, that was *wound*; the two arrays change in place."""
    told = settings.deviations
    keep = np.exp(-np.abs(wound) / told.uneven_length)
    _forget(unknowns, covariance, layout.uneven, keep, np.diag((1.0 - keep * keep) * told.uneven**2))


def load(settings: BodySettings, layout: BodyLayout, unknowns: Array, covariance: Array, ways: Array) -> None:
    """Update the unknown hysteresis strains for the *ways* (m,) of the loads, see `LoadPath`; in place as `wind`.

    Those of lines that are loaded, or unloaded, together are of the same sign rather than not.
    """
    keep = np.exp(-np.abs(ways))
    sizes = 0.5 * settings.deviations.loop * np.sqrt(1.0 - keep * keep)
    alike = np.outer(sizes * np.sign(ways), sizes * np.sign(ways))
    new = _SAME_FRAME * alike + (1.0 - _SAME_FRAME) * np.diag(sizes**2)
    _forget(unknowns, covariance, layout.hysteresis, keep, new)


def _forget(unknowns: Array, covariance: Array, own: slice, keep: Array, new: Array) -> None:
    """*keep* (m,) of the *own* unknowns, and add what is *new*, a covariance (m, m)."""
    unknowns[own] *= keep
    covariance[own] *= keep[:, None]
    covariance[:, own] *= keep
    covariance[own, own] += new
