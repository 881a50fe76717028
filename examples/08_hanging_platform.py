"""Four lines, six degrees of freedom: gravity determines two, wind changes them."""

from math import nan

import cablewright as cw

robot = cw.load("grab-four-lines")
wanted = [1.0, 0.3, -0.2, nan, nan, 0.0]  # m, rad: how it tilts about x and y is left to gravity
calm = cw.inverse(robot, wanted).checked()
print(f"hangs tilted by {calm.pose[3:5].round(4)} rad on tensions of {calm.tensions.round(1)} N")

windy = robot.under_wrench((20.0, 0.0, 0.0))  # N, world, in the platform's origin
blown = cw.forward(windy, calm.lengths).checked()  # the winches stand still: it swings aside
print(f"the wind moves it by {(1e3 * (blown.pose - calm.pose)[:3]).round(1)} mm")

again = cw.inverse(windy, wanted).checked()  # other lengths bring it back to its place, not to its tilt
print(f"in its place again it is tilted by {again.pose[3:5].round(4)} rad")
print(f"largest tension in the wind: {again.tensions.max():.2f} N")
