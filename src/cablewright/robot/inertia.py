"""Which six numbers are the inertia of a body."""

from __future__ import annotations

from cablewright.units import Inertia3
from cablewright.validation import KeyPath, refusal

_TOLERANCE = 1e-12
"""How small the least principal moment may be, relative to their sum: below it, it is rounding and not a body."""

_TRIANGLE_TOLERANCE = 1e-9
"""How far a principal moment may exceed the sum of the other two, relative to their sum: a flat body's rounding."""


def check_inertia(moments: Inertia3, products: Inertia3, within: KeyPath = ()) -> None:
    """Raise a refusal of the key ``inertia`` unless the tensor is that of a body.

    ``moments``: (3,) Ixx, Iyy, Izz and ``products``: (3,) Ixy, Ixz, Iyz, the entries of the symmetric tensor J, kg m^2.
    J is positive definite, and so is tr(J)/2 - J but for a flat body: its eigenvalues are the integrals of x^2, y^2 and
    z^2 over the mass, half of what two principal moments exceed the third by.
    """
    trace = sum(moments)
    if not trace > 0 or not _positive_definite(moments, products, trace):
        raise refusal("inertia", "must be positive definite", within)
    if not _triangle_holds(moments, products, trace):
        why = "no body has these moments: none may exceed the sum of the other two"
        raise refusal("inertia", why, within)


def _positive_definite(moments: Inertia3, products: Inertia3, trace: float) -> bool:
    xx, yy, zz = (moment / trace - _TOLERANCE for moment in moments)
    xy, xz, yz = (product / trace for product in products)
    return _leading_minors_positive(xx, yy, zz, xy, xz, yz)


def _triangle_holds(moments: Inertia3, products: Inertia3, trace: float) -> bool:
    xx, yy, zz = (0.5 - moment / trace + _TRIANGLE_TOLERANCE for moment in moments)
    xy, xz, yz = (-product / trace for product in products)
    return _leading_minors_positive(xx, yy, zz, xy, xz, yz)


def _leading_minors_positive(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> bool:
    second = xx * yy - xy * xy
    third = zz * second - yz * (xx * yz - xy * xz) + xz * (xy * yz - yy * xz)
    return xx > 0 and second > 0 and third > 0
