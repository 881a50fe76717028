"""The part and the motion: G-code, the path of the nozzle, its time law, its layers. Knows no cable and no robot."""

from cablewright.printing.gcode import Toolpath, parse
from cablewright.printing.job import Bead, Job, Motion, Sampling, load_job
from cablewright.printing.layers import LayerTable, layer_table
from cablewright.printing.path import Samples, sample
from cablewright.printing.timing import TimeLaw, time_law

__all__ = [
    "Bead",
    "Job",
    "LayerTable",
    "Motion",
    "Samples",
    "Sampling",
    "TimeLaw",
    "Toolpath",
    "layer_table",
    "load_job",
    "parse",
    "sample",
    "time_law",
]
