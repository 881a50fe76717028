"""What the estimator of a rigid platform has learnt, saved or loaded with a print."""

from __future__ import annotations

import numpy as np

from cablewright.estimation.body.settings import BodySettings
from cablewright.estimation.body.state import BodyState, set_load
from cablewright.machine.simulated.snapshot import Archive


def archive_state(settings: BodySettings, state: BodyState, archive: Archive) -> None:
    """Save or load what the next estimates depend on; windows and doubts begin anew."""
    for name in (
        "unknowns",
        "covariance",
        "home_lengths",
        "home_angles",
        "home_toward",
        "paid",
        "angles",
        "lengths",
        "measured_at",
    ):
        archive.array(name, getattr(state, name))
    for name in ("gradients", "pose_covariance"):
        archive.array(name, getattr(state, name))
    known = archive.count("homed", int(state.home_counts is not None))
    counts = np.zeros(state.layout.m, dtype=np.int64) if state.home_counts is None else state.home_counts
    archive.array("home_counts", counts)
    used = state.cells_used.astype(np.float64)
    archive.array("cells_used", used)
    pose, states = state.tracker.pose.copy(), state.tracker.states.copy()
    archive.array("pose", pose)
    archive.array("states", states)
    state.retraction = (
        archive.number("retraction", state.retraction) if state.retraction == state.retraction else state.retraction
    )
    if archive.loading:
        state.home_counts = counts if known else None
        state.cells_used = used > 0.5
        state.last_counts = None
        state.tracker.pose, state.tracker.states = pose, states
        set_load(state, settings.model)
        state.tracker.restart(state.lengths)
