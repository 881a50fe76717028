"""Names to choose from, on the command line, in files and as arguments."""

from typing import Literal

FileKind = Literal["robot", "job", "machine", "uncertainty", "calibration", "survey"]
"""Kind of a TOML file that is read."""
LayoutName = Literal["suspended", "over-middle", "body", "planar"]
"""Arrangement of the lines of a new robot."""
CableName = Literal[
    "steel-4mm",
    "dyneema-1mm",
    "dyneema-2mm",
    "dyneema-3mm",
    "dyneema-4mm",
    "dyneema-5mm",
    "dyneema-6mm",
    "spectra-1.1mm",
    "belt-at5-10mm",
    "belt-atl5-10mm",
]
"""Cable of a new robot, from a small table."""
ReadFormatName = Literal[
    "wirex",
    "caspr",
    "maslow",
    "wallplotter",
    "maslow-classic",
    "polargraph",
    "makelangelo",
    "klipper",
    "reprapfirmware",
]
"""Format of another program whose robots are read."""
WrittenFormatName = Literal[
    "wirex", "mjcf", "urdf", "stl", "glb", "klipper", "reprapfirmware", "linuxcnc", "gcode", "slicer", "ros2", "maslow",
    "maslow-classic", "wallplotter", "polargraph",
]  # fmt: skip
"""Format of another program that is written."""
RrfVersionName = Literal["3.5", "3.6", "3.7"]
"""Version of RepRapFirmware for which files are written."""
DialectName = Literal["rrf", "klipper"]
"""Firmware whose own kinematics computes the lengths of lines from X Y Z."""
SlicerName = Literal["orca", "prusa", "cura"]
"""Slicer for which a printer's profile is written."""
TargetName = Literal["rrf", "klipper", "orca", "prusa", "cura"]
"""Firmware or slicer for which an export is made."""
WireXVersion = Literal["0.31", "0.32"]
"""Version of WireX's schema."""
CriterionName = Literal["closed-form", "improved-closed-form", "exact", "capacity", "wrench-closure", "static"]
"""Criterion of a workspace; ``static`` counts sag, the others are of straight lines."""
PointName = Literal["nozzle", "origin"]
"""Point of the platform that is meant by a place."""
CountName = Literal["volume", "nodes"]
"""Whether a workspace is a volume with an error, or a count of grid nodes."""
TensionChoice = Literal["least", "middle"]
"""Tensions where many hold a pose: those of least norm, or those nearest to the middle of their limits."""
SwingSignal = Literal["inertial", "load-cells", "positions"]
"""Readings from which the modes of a swing are identified."""
InertiaName = Literal["given", "box"]
"""Inertia of the platform: that of its file, or that of a box about its platform points."""
MethodName = Literal["vertices", "first-order", "monte-carlo"]
"""How the spread of the error is found."""
CompensationName = Literal["none", "elastic", "eyelets", "full"]
"""Model from which the commanded lengths are computed; ``none``: of rigid cables."""
PoseCriterion = Literal["d-optimal", "worst-sigma"]
"""What calibration poses make small: the volume of all unknowns' ellipsoid, or the largest sigma of an exit point."""
PlantName = Literal["dynamic", "quasi-static"]
"""Motion of a simulated machine: with inertia at 10 ms a step, or a sequence of equilibria."""
SeverityName = Literal["ideal", "typical", "rough"]
"""How large the errors of a simulated machine, its room and its sensors are against their description."""
LawName = Literal["paper", "model"]
"""Control law of a print: that of Merlet and Papegay 2023, or the machine's model."""
HeightRule = Literal["structure", "job"]
"""Height of a print: kept above the structure by the vertical lidar, or that of the job."""
WhoRecalibrates = Literal["simulated", "file"]
"""Who calibrates a stage of a print: a simulated person, or a person who puts the files into the run folder."""
ObserverName = Literal["paper", "filter"]
"""Estimator of a log: the estimator of Merlet and Papegay 2023, or the error-state Kalman filter."""
ReplayName = Literal["paper", "filter", "encoders", "both"]
"""Estimators of a replay."""
EstimatorName = Literal["paper", "filter", "encoders"]
"""Estimator of a print: an observer, or dead reckoning by the encoders."""
OptimiserName = Literal["de", "cma-es", "nsga2"]
"""Optimiser of a search for designs."""
