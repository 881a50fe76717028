"""Build a robot from its parts.

A robot need not come from a file: its parts are frozen descriptions too. Numbers are SI; a text may have a unit.
`Robot.from_points` makes one from arrays of points, and `robot.with_(...)` another with changes.
"""

import cablewright as cw

cable = cw.Cable(axial_stiffness="50 kN", linear_density=0.02, breaking_load=5e3, creep=cw.Creep(logarithmic=1e-8))
winch = cw.Winch(drum_radius=0.05, max_speed="1 m/s")
corners = {"sw": (0.0, 0.0, 4.0), "se": (4.0, 0.0, 4.0), "ne": (4.0, 6.0, 4.0), "nw": (0.0, 6.0, 4.0)}
lines = tuple(
    cw.Line(name=name, exit_point=at, cable=cable, sheave=cw.Eyelet(), winch=winch, tension_limits=(5.0, 2e3))
    for name, at in corners.items()
)
beam = cw.Beam(start=(0, 0, 4), end=(4, 0, 4), radius=0.05)
built = cw.Robot(
    name="built",
    scene=cw.Scene(frame_min=(0, 0, 0), frame_max=(4, 6, 4), beams=(beam,)),
    platform=cw.PointPlatform(mass=20.0, loads=(cw.Load(name="full", mass="30 kg"),)),
    lines=lines,
    dynamics=cw.Dynamics(damping_ratio=0.015),
    uncertainty=cw.Uncertainty(parameters=(cw.Uncertain(name="modulus", factor=(0.9, 1.1)),)),
)
assert cw.inverse(built.under_load("full"), (2.0, 3.0, 1.0)).ok

body = cw.RigidPlatform(
    mass=20.0,
    boxes=(cw.Box(lowest=(-0.2, -0.2, 0.0), highest=(0.2, 0.2, 0.3)),),
    retraction=cw.Retraction(length=1.0, least=0.8, most=1.5, lines=("sw",)),
)
corner = [[-2, -2, 3], [2, -2, 3], [2, 2, 3], [-2, 2, 3]]
quick = cw.Robot.from_points(corner, mass=5.0, cable="dyneema-2mm", tension_limits=(1.0, 500.0))
assert quick.with_(mass="8 kg", exit_points=quick.exit_points + 1.0).exit_points.shape == (4, 3)
board = cw.PointPlatform(mass=5.0, plane=cw.Plane(normal=(0, 1, 0), distance=0.0))
sheaves = (
    cw.Swivel(radius=0.04),
    cw.UniversalJoint(radius=0.04, lever=0.2, lever_weight=10.0, lever_mass_centre=0.1),
    cw.Pulley(radius=0.04, axis=(0, 1, 0)),
)
guide = cw.GuideSheave(centre=(0, 0, 3), axis=(0, 1, 0), radius=0.04)
ends = (
    cw.PlatformSheave(radius=0.03, axis=(0, 0, 1)),
    cw.PlatformPulley(radius=0.03, axis=(0, 1, 0), leaves=(0, 0, -1)),
)
shared = cw.SharedWinch(line="sw", offset=0.1)  # on the drum of another line
