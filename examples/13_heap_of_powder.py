"""Powder of a whole exhibition poured along a curve."""

from pathlib import Path

import numpy as np

import cablewright as cw

MASS, ROUNDS = 2560.0, 14  # kg in all, of Merlet and Papegay 2023

job = cw.load_job(Path(__file__).parent / "blind-machines.toml")
samples = job.samples(job.toolpath())
once = samples.positions[samples.layer == 1]
length = np.linalg.norm(np.diff(once, axis=0), axis=1)

powder, field = cw.Powder(), cw.HeightField.flat((-2.2, -4.4), (2.2, 4.4), 0.02)
for _ in range(ROUNDS):
    cw.pour(field, once[:-1], once[1:], MASS / ROUNDS * length / length.sum(), powder)

print(f"{field.volume * powder.density:.3f} kg on {(field.heights > 0).sum() * field.cell**2:.1f} m2")
print(f"highest where the curve crosses itself: {100 * field.heights.max():.1f} cm")
