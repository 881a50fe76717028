"""The terms of reports and docs, one line each, with the symbols that the papers have for them."""

from __future__ import annotations

from typing import NamedTuple


class Term(NamedTuple):
    """A technical term, its symbol in the papers (or empty), and its meaning."""

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
        Term("line", "", "a cable with its exit point, its sheave, its winch and its platform point"),
        Term("winch exit", "", "the point where the cable leaves the winch"),
        Term(
            "exit point",
            "",
            "where the cable leaves the frame: an eyelet, or where a vertical dead span meets the sheave",
        ),
        Term("dead span", "", "the cable between winch exit and sheave"),
        Term("free span", "", "the cable between sheave and platform"),
        Term("eyelet", "", "a fixed point through which the cable runs"),
        Term("swivel", "", "a sheave that swings about a vertical axis"),
        Term(
            "universal joint",
            "",
            "a sheave that swings about a vertical and, with its lever, a horizontal axis (Paty 2021)",
        ),
        Term("lever", "", "the part of a universal joint between its two axes, which the tension lifts"),
        Term("sheave", "", "a wheel that guides the cable"),
        Term("winch drum", "", "the part of a winch on which the cable is wound"),
        Term(
            "platform", "", "the moving body at the ends of the lines, with the tool; a container if it carries powder"
        ),
        Term("payload", "", "mass that the platform carries in addition to its own"),
        Term("obstacle", "", "another line, the platform, the frame or the printed part"),
        Term("platform point", "", "the point of the platform where a line ends"),
        Term("nozzle", "", "the point of the platform that prints"),
        Term("retraction", "", "the adjustable length of an end-effector (Jung 2020)"),
        Term("job", "", "a part with its G-code, its position in the room and its speeds"),
    ),
    "Statics": (
        Term("pose", "", "position of the platform's origin and, of a rigid platform, its rotation vector"),
        Term("unstrained length", "", "length of cable that a winch has paid out, measured without load"),
        Term("wrench", "", "a force and a moment"),
        Term("structure matrix", "", "the matrix whose columns are the unit wrenches of the lines on the platform"),
        Term("inverse problem", "", "from a pose to unstrained lengths and tensions"),
        Term("forward problem", "", "from unstrained lengths to a pose"),
        Term("tension", "", "pulling force in a cable"),
        Term("workspace", "", "the set of poses that meet a criterion"),
        Term("degree of freedom", "", "an independent coordinate of the pose: 3 of a point platform, 6 of a rigid one"),
        Term("equilibrium", "", "a pose at which tensions, weight and wrench balance"),
        Term("taut, slack", "", "a line is slack if it is longer than a straight line with the same ends, else taut"),
        Term("excess", "", "unstrained length of a line less the length of a straight line with the same ends, m"),
        Term("wrench-feasible", "", "tensions within the limits balance the wrench"),
        Term(
            "tension distribution",
            "",
            "the choice among possible tensions: minimum norm, or nearest to the middle of the limits",
        ),
        Term("margin", "", "signed distance from a limit; negative beyond it"),
        Term("tangent stiffness", "", "wrench per small motion of the platform at constant cable lengths"),
        Term("geometric stiffness", "", "the part of the stiffness that is due to tension and load, not to elasticity"),
        Term("fidelity", "", "the physics of a model: cable law and sheave law"),
        Term("certificate", "", "a proof in interval arithmetic that exactly one equilibrium is near a computed one"),
    ),
    "Accuracy": (
        Term("error", "dp, δp", "vector from the commanded to the true position of the nozzle"),
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
            "the model of the commanded lengths: none (rigid cables), elastic, eyelets, full",
        ),
        Term("uncertain parameter", "", "a number of the robot with a known range or standard deviation"),
    ),
    "Calibration and estimation": (
        Term("home lengths", "", "unstrained lengths at encoder zero"),
        Term("datum", "", "the condition that fixes the frame, since length changes do not determine it"),
        Term("sigma", "", "standard deviation"),
        Term("covariance", "", "matrix of the variances and correlations of several estimates"),
        Term("rank", "", "number of unknowns that the data determine"),
        Term("redundancy", "", "number of measured values beyond the unknowns"),
        Term("residual", "", "measured value less the fitted value"),
        Term("predict, update", "", "the two steps of a filter: by its model of motion, and by a measurement"),
        Term(
            "NEES",
            "",
            "normalised estimation error squared; its mean is the number of coordinates if sigmas are right",
        ),
        Term("taut share", "", "share of time in which a line is taut"),
        Term("dead reckoning", "", "a position from the encoders alone"),
    ),
    "Printing": (
        Term("layer", "", "one level of the part; layers are counted from 1"),
        Term("sample", "", "a point of the path at which the model is solved"),
        Term("time law", "", "speed along the path over time, within the limits of speed, acceleration and jerk"),
        Term("plant", "", "the simulation of the real machine, with its imperfections"),
        Term("setpoint", "", "commanded value of a controller"),
        Term("limit", "", "allowed minimum or maximum of a quantity"),
        Term("fault", "", "a condition that stops the machine"),
        Term("warning", "", "a condition that is reported and does not stop the machine"),
        Term("run folder", "", "the output folder of a command: report, pictures, tables, manifest"),
    ),
}
"""Terms by subject."""
