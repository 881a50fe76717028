"""Named columns of the kernels' arrays, to read and write `Packed` and the states of lines."""

from __future__ import annotations

from typing import Self, overload

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array, Mask
from cablewright.kernels import layout


class _View:
    """An array whose last axis has named columns. Setting a column changes the array itself."""

    __slots__ = ("array",)

    def __init__(self, array: Array) -> None:
        self.array = array


class _Columns:
    """A named column, or columns, of a view: a slice of its array without copy, or a number of a single row."""

    def __init__(self, columns: int | slice | list[int], meaning: str) -> None:
        self._index = (..., columns)
        self.__doc__ = meaning

    @overload
    def __get__(self, view: None, owner: type[_View]) -> Self: ...
    @overload
    def __get__(self, view: _View, owner: type[_View]) -> Array: ...
    def __get__(self, view: _View | None, owner: type[_View]) -> Self | Array:
        return self if view is None else view.array[self._index][()]

    def __set__(self, view: _View, value: ArrayLike) -> None:
        view.array[self._index] = value


class LineNumbers(_View):
    """Named columns of `Packed.lines`: numbers of lines under one fidelity, (..., 51), of a batch or a row.

    A point is (..., 3), all else (...). Properties that the fidelity omits are 0: the weight of a cable, the radius of
    an eyelet, the compliance of a rigid cable.
    """

    exit_point = _Columns(slice(layout.EXIT_X, layout.EXIT_Z + 1), "Exit point A, world, m.")
    platform_point = _Columns(slice(layout.POINT_X, layout.POINT_Z + 1), "Platform point B, platform frame, m.")
    radius = _Columns(layout.RADIUS, "Radius of the sheave, m.")
    lever = _Columns(layout.LEVER, "Distance of the sheave's centre from A, m.")
    lever_moment = _Columns(layout.LEVER_MOMENT, "Weight of the lever times its centre of mass's distance from A, N m.")
    side = _Columns(layout.SIDE, "+1 where the cable passes over the sheave, -1 under it.")
    winch_distance = _Columns(layout.WINCH_X, "Horizontal distance of the winch exit from A, m.")
    winch_height = _Columns(layout.WINCH_Z, "Height of the winch exit above A, m.")
    dead_length = _Columns(layout.DEAD_LENGTH, "Length added where the dead span is not modelled, m.")
    weight = _Columns(layout.WEIGHT, "Weight per unstrained length, N/m.")
    free_compliance = _Columns(layout.FREE_COMPLIANCE, "1 / EA of the free span, 1/N.")
    dead_compliance = _Columns(layout.DEAD_COMPLIANCE, "1 / EA of the dead span, 1/N.")
    arc_compliance = _Columns(layout.ARC_COMPLIANCE, "1 / EA of the cable on the sheave, 1/N.")
    compliances = _Columns(slice(layout.FREE_COMPLIANCE, layout.ARC_COMPLIANCE + 1), "All three, (..., 3), 1/N.")
    tension_min = _Columns(layout.TENSION_MIN, "Minimum allowed tension, N.")
    tension_max = _Columns(layout.TENSION_MAX, "Maximum allowed tension, N.")
    tension_limits = _Columns(slice(layout.TENSION_MIN, layout.TENSION_MAX + 1), "Both limits, (..., 2), N.")
    breaking_load = _Columns(layout.BREAKING, "Breaking load, N.")
    unknowns = _Columns(layout.UNKNOWNS, "Number of the line's free unknowns, 3 to 6.")
    spans = _Columns(layout.SPANS, "Spans of the cable between exit and platform point.")
    pulls = _Columns(layout.PULLS, "Tensions at the platform point: spans of all cables of the line.")
    preferred_tension = _Columns(layout.PREFERRED, "Tension to which inverse solutions stay near, N.")

    guide = _Columns(layout.GUIDE, "How a line out of the plane is guided at the frame: a value of `layout`; else 0.")
    axis = _Columns(slice(layout.AXIS_X, layout.AXIS_Z + 1), "Axis of its swivel or pulley, world, (..., 3).")
    arrival = _Columns(
        slice(layout.ARRIVAL_X, layout.ARRIVAL_Z + 1), "Where the cable arrives: see GUIDE of `layout`, (..., 3)."
    )
    dead_span = _Columns(layout.DEAD_SPAN, "Distance that its dead span covers, m.")
    winch_rise = _Columns(layout.WINCH_RISE, "Height of its winch over its sheave, per length of that.")
    mean_rise = _Columns(layout.MEAN_RISE, "Twice the mean height of its dead span over its sheave, per length.")
    rises = _Columns(
        slice(layout.LOW_RISE, layout.HIGH_RISE + 1), "Lowest and highest point of that, likewise, (..., 2)."
    )
    end_radius = _Columns(layout.END_RADIUS, "Radius of its sheave on the platform, m; 0 for none.")
    end_arrival = _Columns(
        slice(layout.END_ARRIVAL_X, layout.END_ARRIVAL_Z + 1),
        "Unit vector to where the cable leaves a pulley on the platform, platform frame, (..., 3); else 0.",
    )
    end_axis = _Columns(slice(layout.END_AXIS_X, layout.END_AXIS_Z + 1), "Axis of that, platform frame, (..., 3).")
    spring = _Columns(layout.END_SPRING, "Stretch of a spring at the winch end per tension of one cable, m/N.")
    counterweight = _Columns(layout.COUNTERWEIGHT, "Tension of one cable that a counterweight holds, N; 0 for a winch.")
    mount = _Columns(
        slice(layout.MOUNT, layout.MOUNT + 6), "Compliance of its exit's mount: xx, yy, zz, xy, xz, yz, (..., 6), m/N."
    )

    @property
    def in_plane(self) -> Mask:
        """(...) bool: whether the line lies in a vertical plane."""
        return np.asarray(self.guide == 0.0)

    @property
    def has_dead_span(self) -> Mask:
        """(...) bool: whether the span between winch and sheave is modelled."""
        return self.unknowns > 3.0

    @property
    def has_lever(self) -> Mask:
        """(...) bool: whether the sheave is on the lever of a universal joint."""
        return self.unknowns > 5.0


class LineStates(_View):
    """Named columns of the lines' unknowns, (..., 6), that a solver finds: `Equilibrium.states`, or a row of it.

    Each is (...), and 0 where the kind of sheave does not have it. Directions are in the line's vertical plane, from
    the horizontal towards the platform point. A line out of the plane has an azimuth and a contact length in place of
    the angles of dead span and lever.
    """

    free_angle = _Columns(layout.PHI, "Direction of the free span where it leaves the sheave, rad.")
    log_tension = _Columns(layout.TAU, "Logarithm of the tension at the sheave, of N.")
    free_length = _Columns(layout.FREE, "Unstrained length of the free span, m.")
    dead_length = _Columns(layout.DEAD, "Unstrained length of the dead span, m.")
    dead_angle = _Columns(layout.PSI, "Direction of the dead span from the sheave towards the winch, rad.")
    lever_angle = _Columns(layout.BETA, "Angle of the lever above the horizontal, rad.")
    azimuth = _Columns(layout.AZIMUTH, "Of a line out of the plane: direction of its free span from +x, rad.")
    contact_length = _Columns(layout.CONTACT, "Of a line out of the plane: length of cable on its sheaves, m.")
    angles = _Columns([layout.PHI, layout.PSI, layout.BETA], "The three angles, (..., 3), rad; reading returns a copy.")

    @property
    def tension(self) -> Array:
        """Tension (...) at the sheave, N; tiny, not 0, where a massless line is slack."""
        return np.exp(self.log_tension)


class PlatformNumbers(_View):
    """Named entries of `Packed.platform`, (..., 16), or that of a batch."""

    centre_of_mass = _Columns(slice(layout.MASS_X, layout.MASS_Z + 1), "(..., 3) platform frame, m.")
    weight = _Columns(layout.PLATFORM_WEIGHT, "(...) N.")
    wrench = _Columns(slice(layout.WRENCH, layout.WRENCH + 6), "(..., 6) external force, N, and moment, N m, world.")
    massless = _Columns(
        layout.MASSLESS, "(...) 1 where any line has no weight, so that its tension is 0 when slack; else 0."
    )
    held = _Columns(layout.HELD, "(...) 1 where a plane carries the platform across it; else 0.")
    normal = _Columns(slice(layout.NORMAL, layout.NORMAL + 3), "(..., 3) unit vector across the plane, world.")
    plane_distance = _Columns(layout.PLANE_DISTANCE, "(...) of the plane from the world's origin along its normal, m.")


def blank_states(*shape: int) -> Array:
    """Return unknowns of lines, all 0, (*shape, 6), for a solver to write into."""
    return np.zeros((*shape, layout.STATE))
