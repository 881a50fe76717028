"""Stress in the bracket of a sheave, two designs."""

import cablewright as cw

found = cw.bracket(cw.load("house-printer"), [-2.25, -6.75, 13.0], times=1).designs
for name, design in (("universal joint", found.universal_joint), ("conventional", found.conventional)):
    moment = abs(design.loads.pin_moment[0, design.line])
    print(f"{name}: {moment:.1f} N m about the pin, safety {design.safety:.2f}")
    for peak in design.peaks:
        print(f"  {peak.part}: {peak.stress / 1e6:.1f} MPa")
spared = found.conventional.max_von_mises - found.universal_joint.max_von_mises
print(f"spared by the universal joint: {spared / 1e6:.1f} MPa")
