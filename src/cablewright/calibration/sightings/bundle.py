"""Bundle adjustment of pictures of tags: poses, lens and tag positions in one least-squares problem.

It finds tags that are not at the position in the layout, and single sightings that do not fit, before anything else is
measured by them. Both are tested by how much the sum of squares falls without them; the greater one is removed first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy import special

from cablewright.calibration.sightings.detection import EDGES
from cablewright.calibration.sightings.sighted import Bodies, Sightings
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.fitting import calibration_residuals, line_over_sheave, pose_schur
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.kernels.fitting.pose_schur import StopRule

_STOP: Final = StopRule(1e-10, 1e-12, 300, 1e-4)
_LEVEL: Final = 1e-3  # probability that a right tag is named, or a right sighting left out, in a set of pictures
_MOST: Final = 60  # sightings left out
_SMALL: Final = 1e-9  # of the largest eigenvalue: what has no information
_MANY: Final = 0.3  # share of the sightings left out beyond which the layout or the camera is not that of the pictures
OTHER_CAMERA: Final = 4.0  # squares of the lens from its file over those of chance, beyond which it is another camera
_MOVED: Final = 0.5  # share of the tags that moved, beyond which it is the layout or the camera too


@dataclass(frozen=True, eq=False)
class Bundle:
    """The bundle adjustment problem of N pictures with T tags: e = 8 T rows at each, and rows without a pose."""

    bodies: Bodies
    rows: MeasurementRows
    values: Array  # (N e,)
    weights: Array  # (N e,)
    theta: Array  # (s,)
    poses: Array  # (N, 6)

    @classmethod
    def of(cls, seen: Sightings, poses: Array, free_camera: bool) -> Bundle:
        """Build the bundle adjustment problem from start *poses* (N, 6)."""
        bodies, blocks = seen.bodies(free_camera=free_camera), list(seen.rows())
        values, weights = (np.concatenate([block[at] for block in blocks], axis=1) for at in (1, 2))
        extra, count = np.concatenate([block[3] for block in blocks], axis=1), values.size
        rows = MeasurementRows(
            freedoms=6,
            start=np.arange(len(poses) + 1, dtype=np.int64) * values.shape[1],
            kind=np.full(count, calibration_residuals.SIGHTING, dtype=np.int64),
            line=np.zeros(count, dtype=np.int64),
            other=np.tile(np.repeat(np.arange(1, len(blocks) + 1), EDGES), len(poses)),
            extra=np.ascontiguousarray(extra.reshape(-1, 6)),
            lines=np.zeros((0, line_over_sheave.COLUMNS)),
            target=np.zeros((0, line_over_sheave.COLUMNS), dtype=np.int64),
            tensions=np.zeros((len(poses), 0)),
            load=np.zeros(10),
            linear=bodies.linear,
            wanted=bodies.wanted,
            bodies=bodies.table,
            body_target=bodies.target,
            guided=None,
        )
        start = np.array([each.start for each in bodies.unknowns])
        return cls(bodies, rows, values.ravel(), weights.ravel(), start, np.array(poses, order="C"))

    def fitted(self) -> tuple[Bundle, float]:
        """Return the bundle at its minimum, and half the sum of squares there."""
        theta, poses = self.theta[None].copy(), self.poses[None].copy()
        limits = np.array([[each.low for each in self.bodies.unknowns], [each.high for each in self.bodies.unknowns]])
        codes, steps, costs = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64), np.zeros(1)
        pose_schur.adjust_runs(
            self.rows, np.eye(6), np.ascontiguousarray(limits.reshape(2, -1)), theta, poses, self.values[None],
            self.weights[None], _STOP, codes, steps, costs,
        )  # fmt: skip
        return replace(self, theta=theta[0], poses=poses[0]), float(costs[0])

    def evidence(self) -> tuple[Array, Array, Array, Array]:
        """Return residuals (N, e), the fit's share of them (N, e, e), residuals of the linear rows, and the covariance.

        The covariance (s, s) is of the unknowns, the poses eliminated; residuals are over their sigmas.
        """
        count, k = len(self.poses), len(self.theta)
        residual, slopes = np.zeros(len(self.values)), np.zeros((len(self.values), 6))
        gradients = np.zeros((len(self.values), k))
        calibration_residuals.derivatives(
            self.rows, np.eye(6), self.theta, self.poses, self.values, self.weights, residual, slopes, gradients
        )
        off, by_pose, by_theta = (
            each.reshape(count, len(self.values) // count, -1) for each in (residual, slopes, gradients)
        )
        left, sizes, _ = np.linalg.svd(by_pose, full_matrices=False)
        kept = left * (sizes > _SMALL * sizes.max(axis=1, keepdims=True, initial=1e-300))[:, None]
        rest = by_theta - kept @ (np.swapaxes(kept, 1, 2) @ by_theta)
        root = np.concatenate([rest.reshape(-1, k), self.rows.linear])
        covariance = np.linalg.pinv(root.T @ root, rcond=1e-14, hermitian=True)
        shares = kept @ np.swapaxes(kept, 1, 2) + rest @ covariance @ np.swapaxes(rest, 1, 2)
        return off[..., 0], shares, self.rows.linear @ self.theta - self.rows.wanted, covariance

    @property
    def groups(self) -> Iterator[tuple[int, slice]]:
        """The tags, and the rows of each pose that belong to them."""
        for index in range(len(self.bodies.tags)):
            yield index, slice(EDGES * index, EDGES * (index + 1))


def consistent(seen: Sightings, poses: Array, free_camera: bool) -> tuple[Sightings, Bundle]:
    """Return the sightings that fit each other, and the bundle of these pictures at its minimum.

    Sightings that do not fit are in ``left_out`` of the result, tags that moved in ``moved``. *poses* (N, 6): where the
    fit starts. *free_camera*: whether the pictures determine the camera's position.
    """
    bundle, _ = Bundle.of(seen, poses, free_camera).fitted()
    total = max(int(seen.counts.sum()), 1)
    while True:
        off, shares, stated, covariance = bundle.evidence()
        sigma, worst = _spread(bundle, off, shares), (0.0, -1, -1)
        for index, rows in bundle.groups:
            tag, own = bundle.bodies.tags[index], np.flatnonzero(bundle.bodies.of_tag == index)
            if len(own) and tag.number not in seen.moved:
                linear = bundle.rows.linear[own]
                left = np.eye(len(own)) - linear @ covariance @ linear.T
                worst = max(worst, (excess_of(stated[own], left, 1.0, len(bundle.bodies.tags)), -1, tag.number))
            used = bundle.weights.reshape(off.shape)[:, rows.start] > 0.0
            for at in np.flatnonzero(used).tolist():
                left = np.eye(EDGES) - shares[at, rows, rows]
                worst = max(worst, (excess_of(off[at, rows], left, sigma, total), at, tag.number))
        excess, at, number = worst
        if excess <= 1.0:
            of_lens = bundle.bodies.of_tag < 0
            linear = bundle.rows.linear[of_lens]
            if excess_of(stated[of_lens], np.eye(len(linear)) - linear @ covariance @ linear.T, 1.0, 1) > OTHER_CAMERA:
                raise InputError(
                    "pictures: the lens or the size of the print that fits them is far from its file: is the camera's "
                    "file of this camera, with its focus and zoom, and are the sizes of the tags right?"
                )
            return seen, bundle
        out, moved, tags = len(seen.left_out), len(seen.moved), len(bundle.bodies.tags)
        if out >= min(max(_MANY * total, 1.0), _MOST) or moved + (at < 0) > max(_MOVED * tags, 1.0):
            raise InputError(
                f"pictures: {out} of {total} sightings and {moved} of {tags} tags do not fit the others: "
                "is the camera's file of this camera, with its focus and zoom, are sizes and places of the tags right, "
                "and is a sheet flat? Tags that were placed roughly need a larger sigma"
            )
        if at < 0:
            seen = replace(seen, moved=(*seen.moved, number))
        else:
            seen = replace(seen, left_out=seen.left_out | {(at, number)})
        bundle, _ = Bundle.of(seen, bundle.poses, free_camera).fitted()


def _spread(bundle: Bundle, off: Array, shares: Array) -> float:
    """Return the sigma of the edges over that stated, from the median of the sightings' squares; at least 1."""
    ratios = []
    for _, rows in bundle.groups:
        free = EDGES - np.trace(shares[:, rows, rows], axis1=1, axis2=2)
        used = (bundle.weights.reshape(off.shape)[:, rows.start] > 0.0) & (free > 1.0)
        ratios += (np.sum(off[used][:, rows] ** 2, axis=1) / free[used]).tolist()
    return max(1.0, float(np.sqrt(np.median(ratios)))) if ratios else 1.0


def excess_of(off: Array, left: Array, sigma: float, among: int) -> float:
    """Return the squares that rows *off* (r,) add to the sum, over what chance makes of the worst *among* so many.

    *left* (r, r): their covariance, singular where nothing tests them.
    """
    values, vectors = np.linalg.eigh(left)
    tested = values > 1e-6
    if not tested.any():
        return 0.0
    square = float(np.sum((vectors[:, tested].T @ off) ** 2 / values[tested]))
    return square / (sigma**2 * float(special.chdtri(int(tested.sum()), _LEVEL / among)))
