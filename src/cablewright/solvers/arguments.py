"""Arguments of the solvers: shapes, finite numbers, and the choice of the serial or the parallel kernel."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.units import LARGEST
from cablewright.models.packed_views import PlatformNumbers
from cablewright.models.plane import projected
from cablewright.models.rotation import rotations, shortest
from cablewright.models.statics import Model
from cablewright.robot import Plane
from cablewright.robot.plane import OFF_PLANE

log = logging.getLogger(__name__)

CARRIED = 1e-9  # of the load: part in the plane under which the plane carries the whole load
ROUNDING = 4e-16  # of a coordinate


def as_rows(values: ArrayLike, width: int, what: str, unit: str) -> tuple[Array, bool]:
    """Return *values* as a new (rows, width) array, and whether they were a single row.

    Raises `InputError` for a wrong count, text or numbers that are not finite.
    """
    array = _numbers(values, (width,), what, unit)
    _refuse(array, ~(np.abs(array) <= LARGEST), what)
    return np.atleast_2d(array), array.ndim == 1


def as_lengths(model: Model, values: ArrayLike) -> tuple[Array, bool]:
    """Return unstrained lengths as a new (rows, m) array, m, and whether they were a single row.

    That of a line with a counterweight is not read. Raises `InputError` as `as_rows`, and unless all are over zero.
    """
    hung = np.flatnonzero(model.lines.counterweight)
    if len(hung):
        values = _numbers(values, (model.m,), "lengths", "m")
        values[..., hung] = np.delete(values, hung, axis=-1).min(axis=-1, keepdims=True)  # no larger one: a tolerance
    length, single = as_rows(values, model.m, "lengths", "m")
    if not (length > 0.0).all():
        raise InputError(f"lengths: every length must be over zero; got {length[length <= 0.0][0]:g} m")
    return length, single


def _numbers(values: ArrayLike, widths: tuple[int, ...], what: str, unit: str) -> Array:
    """*values* as a new array of one row, or of rows, of an allowed width. Raises `InputError`."""
    if type(values) is np.ndarray and values.dtype == np.float64:  # of a loop of control: nothing to ask
        array = values.copy()
    else:
        array = _converted(values, what, unit)
    if array.ndim not in (1, 2) or array.shape[-1] not in widths:
        shape = " x ".join(map(str, array.shape)) or "a single number"
        raise InputError(f"{what}: {widths[0]} numbers are expected, or rows of {widths[0]}; got {shape}")
    return array


def _converted(values: ArrayLike, what: str, unit: str) -> Array:
    """*values* of any type as a new array of floats. Raises `InputError`."""
    if np.ma.is_masked(values):
        raise InputError(f"{what}: numbers in {unit} are expected; some are masked")
    try:
        if np.iscomplexobj(values):
            raise TypeError("complex numbers")
        return np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as reason:
        raise InputError(f"{what}: numbers in {unit} are expected ({reason})") from None


def _refuse(array: Array, wrong: NDArray[np.bool_], what: str) -> None:
    """Raise `InputError` where a number is not finite, or so large that products overflow."""
    if wrong.any():
        first = array[wrong][0]
        bound = f"at most {LARGEST:g} in size" if np.isfinite(first) else "finite"
        raise InputError(f"{what}: every number must be {bound}; got {first}")


def as_poses(model: Model, values: ArrayLike, what: str, *, free: bool = False) -> tuple[Array, bool]:
    """Return poses as a new (rows, n) array, and whether they were a single row.

    A rigid body's pose may be its position alone: unrotated. A rotation vector longer than pi is replaced by the
    equivalent shorter one, with a warning in the log. If *free*, NaN marks coordinates that gravity decides on a
    robot with fewer winches than degrees of freedom. One coordinate of a position in a plane may be NaN: the plane
    decides it. Raises `InputError` for a wrong count or numbers that are not finite, and for a pose off the platform's
    plane.
    """
    n, freedoms, plane = model.n, model.freedoms, model.robot.platform.plane
    array = _numbers(values, (n, 3), what, "m and rad")
    poses = np.atleast_2d(array)
    if poses.shape[1] < n:
        poses = np.concatenate([poses, np.zeros((len(poses), 3))], axis=1)
    if plane is not None:
        _complete(plane, poses)
        _require_held(plane, poses, what)
    wrong = ~(np.abs(poses) <= LARGEST)
    if free and (model.winches < freedoms or np.isnan(poses).any()):
        if model.robot.platform.in_tilted_plane and (model.winches < freedoms or model.robot.sharing):
            raise InputError(
                f"{what}: {_holders(model)} hold {freedoms} degrees of freedom in a plane across x, y or z alone"
            )
        _require_enough_free(model, freedoms - np.isnan(poses).sum(axis=1), what)
        wrong = np.abs(poses) > LARGEST
    _refuse(poses, wrong, what)
    poses[:, 3:] = _short_turns(poses[:, 3:], what)
    if plane is not None:
        _into_plane(plane, poses, what)
    return poses, array.ndim == 1


def _holders(model: Model) -> str:
    """What holds the platform, in words: lines, or fewer winches."""
    return f"{model.m} lines" + ("" if model.winches == model.m else f" on {model.winches} winches")


def _require_enough_free(model: Model, given: NDArray[np.int64], what: str) -> None:
    """Raise `InputError` unless as many coordinates are *given* (rows,) as lines hold, and the others free.

    Where lines share winches, tensions may adapt where rotations are free, so that fewer may be given: the position.
    """
    winches, freedoms = model.winches, model.freedoms
    most = min(winches, freedoms)
    least = min(winches, 2 if model.robot.platform.plane is not None else 3) if model.robot.sharing else most
    wrong = given[(given < least) | (given > most)]
    if not len(wrong):
        return
    if winches >= freedoms and not model.robot.sharing:
        raise InputError(f"{what}: {model.m} lines hold all {freedoms} degrees of freedom: none can be free (nan)")
    count = f"{_holders(model)} hold {most} of the {freedoms} degrees of freedom; {wrong[0]} are given"
    free = f"{freedoms - most}" if least == most else f"{freedoms - most} to {freedoms - least}"
    raise InputError(f"{what}: {count}: leave {free} free (nan) for gravity")


def _complete(plane: Plane, poses: Array) -> None:
    """Where one coordinate of a position in *poses* (rows, n) that the plane decides is NaN, write it."""
    normal = np.array(plane.across)
    leaning = np.flatnonzero(normal)
    for k in leaning:
        others = leaning[leaning != k]
        rows = np.isnan(poses[:, k]) & ~np.isnan(poses[:, others]).any(axis=1)
        poses[rows, k] = (plane.distance - poses[rows][:, others] @ normal[others]) / normal[k]


def _require_held(plane: Plane, poses: Array, what: str) -> None:
    """Raise `InputError` for a NaN in *poses* (rows, n) where the plane decides, and could not."""
    normal = np.array(plane.across)
    held = np.concatenate([normal != 0.0, normal == 0.0])[: poses.shape[1]]
    if np.isnan(poses[:, held]).any():
        raise InputError(f"{what}: what the plane {plane} holds cannot be left free (nan)")


def _into_plane(plane: Plane, poses: Array, what: str) -> None:
    """Move *poses* (rows, n) by up to `OFF_PLANE` into the plane. Raises `InputError` for one that is farther off."""
    normal = np.array(plane.across)
    known = np.nan_to_num(poses)
    off = known[:, :3] @ normal - plane.distance
    turns = rotations(known)
    aside = turns - (turns @ normal)[:, None] * normal
    turned = np.linalg.norm(aside, axis=1)
    far = np.flatnonzero((np.abs(off) > OFF_PLANE + ROUNDING * np.abs(known[:, :3]).max(axis=1)) | (turned > OFF_PLANE))
    if len(far):
        row = far[np.argmax(np.maximum(np.abs(off), turned)[far])]
        at = ", ".join(f"{x:.6g}" for x in poses[row])
        if turned[row] > OFF_PLANE:
            raise InputError(f"{what} {at}: turned by {turned[row]:.4g} rad out of the platform's plane {plane}")
        why = f"{off[row]:.4g} m off the platform's plane {plane}; one coordinate can be left free (nan)"
        raise InputError(f"{what} {at}: {why}")
    poses[:, :3] -= off[:, None] * normal
    poses[:, 3:] -= aside[:, : poses.shape[1] - 3]


def _short_turns(vectors: Array, what: str) -> Array:
    """Rotation vectors (rows, 3) of at most pi; those with a free component are not changed."""
    if not vectors.size:
        return vectors
    angle = np.linalg.norm(vectors, axis=1)
    long = np.flatnonzero(angle > np.pi)
    if len(long) == 0:
        return vectors
    short = shortest(vectors)
    same = ", ".join(f"{x:.6g}" for x in short[long[0]])
    more = f" (and {len(long) - 1} more)" if len(long) > 1 else ""
    log.warning(
        "%s: a rotation vector of %.6g rad exceeds pi and is replaced by the equivalent %s%s",
        what,
        angle[long[0]],
        same,
        more,
    )
    return short


def require_a_load(model: Model) -> None:
    """Raise `InputError` where nothing loads the lines: tensions of least norm would be zero."""
    platform, free = PlatformNumbers(model.packed.platform), model.free_directions
    if free is None and (platform.weight > 0.0 or platform.wrench.any()):
        return
    load = np.array(platform.wrench[: model.n])
    load[2] -= platform.weight
    if (np.abs(projected(free, load)) > CARRIED * np.abs(load).max()).any():
        return
    why = "gravity = 0, no external force" if free is None else "the plane carries the whole load"
    if model.winches < model.freedoms:
        raise InputError(f"{why}: {_holders(model)} leave degrees of freedom undetermined")
    if not model.lines.tension_min.any():
        raise InputError(f"{why}: a line's tension_limits must begin above 0, or all are slack")


def given_rows(values: ArrayLike, rows: int, width: int, what: str, unit: str) -> Array:
    """Return *values*, one row for all problems or one for each, as (rows, width). Raises `InputError`."""
    given, _ = as_rows(values, width, what, unit)
    if len(given) not in (1, rows):
        raise InputError(f"{what}: one row, or {rows} as there are problems, is expected; got {len(given)}")
    return np.broadcast_to(given, (rows, width))


def given_numbers(values: ArrayLike | None, rows: int, what: str, unit: str) -> Array | None:
    """Return *values*, one number for all problems or one for each, as (rows,); None stays None.

    Raises `InputError`.
    """
    if values is None:
        return None
    return given_rows(np.atleast_1d(np.asarray(values))[..., None], rows, 1, what, unit)[:, 0].copy()
