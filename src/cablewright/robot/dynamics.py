"""Damping of the platform's vibrations, and the check of its inertia tensor."""

from __future__ import annotations

from typing import Annotated, Final, NamedTuple, Self

from pydantic import Strict, model_validator

from cablewright.foundation.units import Inertia3
from cablewright.foundation.validation import Description, KeyPath, refusal

ASSUMED_DAMPING: Final = 0.01
"""Share of critical damping of a robot whose file gives none: real suspended robots have 0.002 to 0.06."""


class Damping(NamedTuple):
    """Damping ratio (share of critical damping) of every mode of a platform, and whether it is assumed."""

    ratio: float
    is_assumed: bool

    def __str__(self) -> str:
        return f"{100.0 * self.ratio:.3g} %{' (assumed)' if self.is_assumed else ''}"


class Dynamics(Description):
    """Vibration data of the robot file. ``damping_ratio``: share of critical damping of each mode; None: unknown."""

    damping_ratio: Annotated[float, Strict()] | None = None

    @model_validator(mode="after")
    def _oscillates(self) -> Self:
        ratio = self.damping_ratio
        if ratio is not None and not 0.0 <= ratio < 1.0:
            meant = f"; did you mean {ratio:g} %, {ratio / 100.0:g}?" if 1.0 < ratio < 100.0 else ""
            why = f"must be a share of critical damping, at least 0 and below 1{meant}"
            raise refusal("damping_ratio", why)
        return self

    @property
    def damping(self) -> Damping:
        """The damping to use: that of the file, or else `ASSUMED_DAMPING`."""
        assumed = self.damping_ratio is None
        return Damping(ASSUMED_DAMPING if self.damping_ratio is None else self.damping_ratio, assumed)


_TOLERANCE = 1e-12
"""Minimum of the smallest principal moment, as a share of their sum; below it is rounding."""

_TRIANGLE_TOLERANCE = 1e-9
"""Tolerance of the triangle inequality, as a share of the moments' sum: rounding of a flat body's moments."""


def check_inertia(moments: Inertia3, products: Inertia3, within: KeyPath = ()) -> None:
    """Raise `refusal` of ``inertia``, a key ``within`` the model, unless the tensor is that of a body.

    ``moments``: (3,) Ixx, Iyy, Izz and ``products``: (3,) Ixy, Ixz, Iyz, the entries of the symmetric tensor J, kg m^2.
    J must be positive definite, and tr(J)/2 - J too (semidefinite for a flat body): its eigenvalues are the integrals
    of x^2, y^2 and z^2 over the mass.
    """
    trace = sum(moments)
    if not trace > 0:
        raise refusal("inertia", "must be positive definite", within)
    diagonal, off_diagonal = [moment / trace for moment in moments], [product / trace for product in products]
    if not _is_positive_definite(*(each - _TOLERANCE for each in diagonal), *off_diagonal):
        raise refusal("inertia", "must be positive definite", within)
    if not _is_positive_definite(*(0.5 - each + _TRIANGLE_TOLERANCE for each in diagonal), *(-p for p in off_diagonal)):
        raise refusal("inertia", "no body has these moments: none may exceed the sum of the other two", within)


def _is_positive_definite(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> bool:
    """Whether all leading minors are positive."""
    second = xx * yy - xy * xy
    third = zz * second - yz * (xx * yz - xy * xz) + xz * (xy * yz - yy * xz)
    return xx > 0 and second > 0 and third > 0
