"""The record of a print as one JSON object: SI, variances in m^2 and (m/s)^2, NaN as null."""

from __future__ import annotations

import json
import math
from typing import Any, Final

from cablewright.results import plain
from cablewright.studies.prints.result import PathFollowing, PrintRecord
from cablewright.studies.prints.structure import HeightDifference, PrintedStructure
from cablewright.studies.running_statistics import Summary

_Values = dict[str, Any]

SCHEMA: Final = 1


def metrics(found: PrintRecord) -> _Values:
    """Return all figures by name. Path errors and speeds are true ones, except where names begin with ``estimated``."""
    return {
        "layers": found.layers,
        "layers_begun": found.layers_begun,
        "distance": found.distance - found.begin,
        "end": found.distance,
        "travelled": found.travelled,
        "steps": found.steps,
        "duration": found.duration,
        **_following(found.true, ""),
        **_following(found.estimated, "estimated_"),
        "mean_estimation_error": found.estimation_error.mean,
        "estimation_error_variance": found.estimation_error.variance,
        "wanted_speed": found.print_speed,
        "yaw": _range(found.yaw),
        "tilt": _range(found.tilt),
        "temperature": _range(found.temperature),
        "humidity": _range(found.humidity),
        "states": {str(state): time for state, time in found.states.items()},
        "barrier_stops": found.barrier_stops,
        "refills": found.refills,
        "faults": [
            {"source": source, "sentence": sentence, "since": since, "until": until, "steps": steps}
            for (source, sentence), (since, until, steps) in found.faults.items()
        ],
        "notices": dict(found.notices),
        "lines": found.lines,
        "structure": None if found.structure is None else _structure(found.structure),
        "notes": list(found.notes),
    }


def metrics_text(found: PrintRecord, more: _Values | None = None) -> str:
    """Return `metrics` and *more* figures as the text of metrics.json."""
    return json.dumps(plain({"schema": SCHEMA} | metrics(found) | (more or {})), indent=1, allow_nan=False) + "\n"


def _following(found: PathFollowing, prefix: str) -> _Values:
    error, speed, height = found.error, found.speed, found.height
    return {
        f"{prefix}mean_path_error": error.mean,
        f"{prefix}path_error_variance": error.variance,
        f"{prefix}max_path_error": error.size,
        f"{prefix}worst_place": found.worst,
        f"{prefix}mean_height_error": height.mean,
        f"{prefix}height_error_variance": height.variance,
        f"{prefix}max_height_error": height.size,
        f"{prefix}mean_speed": speed.mean,
        f"{prefix}speed_variance": speed.variance,
        f"{prefix}steps_printing": error.count,
    }


def _range(found: Summary) -> _Values:
    return {"mean": found.mean, "min": found.min, "max": found.max}


def _structure(found: PrintedStructure) -> _Values:
    difference = HeightDifference(*(math.nan,) * 5) if found.difference is None else found.difference
    return {
        "mass": found.mass,
        "volume": found.mass / found.density,
        "estimated_mass": found.estimated_mass,
        "estimated_volume": found.estimated_mass / found.density,
        "max_height": found.highest,
        "mean_difference": difference.mean,
        "rms_difference": difference.rms,
        "max_difference": difference.max,
        "rms_difference_on_structure": difference.on_structure,
        "share_seen": difference.share_seen,
    }
