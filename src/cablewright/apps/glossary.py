"""The terms of reports and docs, one line each, with the symbols that the papers have for them."""

from typing import NamedTuple


class Term(NamedTuple):
    """A term, its symbol in the papers (or empty), and what it means."""

    name: str
    symbol: str
    meaning: str


GLOSSARY = {
    "The machine": (
        Term(
            "cable-driven parallel robot (CDPR)",
            "",
            "a robot whose platform is held and moved by cables that winches pay out",
        ),
        Term("line", "", "one cable with its winch, its sheave and its point at the platform"),
        Term("winch exit", "", "the point where the cable leaves the winch"),
        Term(
            "exit point",
            "",
            "the point where the cable leaves the frame: eyelet, or where a vertical dead span meets the sheave",
        ),
        Term("dead span", "", "the cable between winch exit and sheave"),
        Term("free span", "", "the cable between sheave and platform"),
        Term("eyelet", "", "a point that the cable runs through"),
        Term("swivel", "", "a sheave that swings about a vertical axis"),
        Term(
            "universal joint",
            "",
            "a sheave that swings about a vertical and, with its lever, a horizontal axis (Paty 2021)",
        ),
        Term("lever", "", "the part of a universal joint between its two axes, which the tension lifts"),
        Term("platform point", "", "the point of the platform where a line ends"),
        Term("nozzle", "", "the point of the platform that prints"),
        Term("retraction", "", "the length by which an end-effector is drawn in (Jung 2020)"),
        Term("job", "", "a part with its G-code, its place in the room and its speeds"),
    ),
    "Statics": (
        Term("pose", "", "position of the platform's origin and, of a rigid platform, its rotation vector"),
        Term("unstrained length", "", "length of cable that a winch has paid out, measured without load"),
        Term("wrench", "", "a force and a moment"),
        Term("structure matrix", "", "the matrix whose columns are the unit wrenches of the lines on the platform"),
        Term("inverse problem", "", "from a pose to unstrained lengths and tensions"),
        Term("forward problem", "", "from unstrained lengths to a pose"),
        Term("equilibrium", "", "a pose at which tensions, weight and wrench balance"),
        Term("taut, slack", "", "a line is slack as far as it is longer than a straight line with the same ends"),
        Term("excess", "", "that surplus of length, m"),
        Term("wrench-feasible", "", "tensions within the limits balance the wrench"),
        Term(
            "tension distribution",
            "",
            "which of the possible tensions are taken: least norm, or nearest to the middle of the limits",
        ),
        Term("margin", "", "signed distance from a limit; negative where it is broken"),
        Term("tangent stiffness", "", "wrench per small motion of the platform, winches held"),
        Term("geometric stiffness", "", "the part of it from tension and load rather than from elasticity"),
        Term("fidelity", "", "which physics a model has: cable law and sheave law"),
        Term("certificate", "", "a proof in interval arithmetic that exactly one equilibrium is near a computed one"),
    ),
    "Accuracy": (
        Term("error", "dp, δp", "vector from where the nozzle should be to where it is"),
        Term("nominal error", "dp_n", "length of the error if all parameters have their nominal values"),
        Term("max error", "dp_max", "largest length of the error over the ranges of the uncertain parameters"),
        Term("difference", "Δp", "max error less nominal error"),
        Term("deviation", "δp from the nominal position", "distance from the position with nominal parameters"),
        Term(
            "region",
            "Ω",
            "the set of positions over the ranges of the parameters",
        ),
        Term(
            "compensation",
            "",
            "which model the commanded lengths come from: none (rigid cables), elastic, eyelets, full",
        ),
        Term("uncertain parameter", "", "a number of the robot that is known within a range"),
    ),
    "Calibration and estimation": (
        Term("home lengths", "", "unstrained lengths where the encoders count zero"),
        Term("datum", "", "what fixes the frame that length changes alone leave open"),
        Term("sigma", "", "standard deviation"),
        Term("rank", "", "number of unknowns that the data determine"),
        Term("redundancy", "", "number of measured values beyond the unknowns"),
        Term("residual", "", "what is left of a measured value after the fit"),
        Term("predict, update", "", "the two steps of a filter: by its model of motion, and by a measurement"),
        Term(
            "NEES",
            "",
            "normalised estimation error squared; its mean is the number of coordinates if sigmas are right",
        ),
        Term("taut share", "", "share of the time in which a line is taut"),
        Term("dead reckoning", "", "a position from the encoders alone"),
    ),
    "Printing": (
        Term("layer", "", "one level of the part; layers are counted from 1"),
        Term("sample", "", "one point of the path at which everything is computed"),
        Term("time law", "", "speed along the path over time, within the limits of speed, acceleration and jerk"),
        Term("plant", "", "what is simulated as the real machine, with its imperfections"),
        Term("run folder", "", "the folder with all that a command wrote: report, pictures, tables, manifest"),
    ),
}
"""Terms by subject."""
