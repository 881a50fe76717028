"""A rigid platform: hold a pose, tilt it, retract it."""

import cablewright as cw

robot = cw.load("jung2020")
straight = [0.3, 0.2, 0.4]  # m, world: a position alone means unrotated
tilted = [0.3, 0.2, 0.4, 0.1, 0.0, 0.0]  # and a rotation vector, rad: 0.1 rad about the world's x

held = {
    "straight": cw.inverse(robot, straight).checked(),
    "tilted by 0.1 rad": cw.inverse(robot, tilted).checked(),
    "straight, 1.4 m long": cw.inverse(robot, straight, retraction=1.4).checked(),
}
for what, found in held.items():
    print(f"{what:<21}", "  ".join(f"{tension:4.1f}" for tension in found.tensions), "N")

back = cw.forward(robot, held["tilted by 0.1 rad"].lengths)  # from the lengths alone, without a guess
print(f"forward leads back to {back.pose[:3].round(6) + 0.0} m, {back.pose[3:].round(6) + 0.0} rad")

stiffness = cw.linearise(held["straight"]).stiffness  # (6, 6): forces and moments per translation and rotation
print(f"against tilting about x: {stiffness[3, 3] / 1e3:.1f} kNm/rad")
print(f"against turning about z: {stiffness[5, 5]:.2f} Nm/rad")
