"""Wang and Caro 2021 beside cablewright: his mu by tolerances and poses, with and without Jacobian; and what 0.1 mm is.

The paper prints neither the robot's dimensions, nor the poses, nor the errors of starts, nor its bounds. Assumed: the
exit points of `wang2021`, random poses in its workspace, starts within 10 mm, bounds 50 mm around what is true.
"""

import argparse
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import cablewright as cw
from cablewright.calibration.poses.fit import fits
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.poses.simulation import measure, random_poses

ROBOT = cw.load("wang2021")
TRUE = np.array([line.exit_point for line in ROBOT.lines])
OFF, BOUND = 0.01, 0.05  # m: starts, and bounds lb and ub, about the truth
POSES = (12, 16, 20, 24, 32, 40)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


class Case:
    """Encoders without noise at *count* poses, and starts."""

    def __init__(self, count: int, starts: int) -> None:
        rng = np.random.default_rng(count)
        self.made = measure(ROBOT, random_poses(ROBOT, count, rng), 0.0, rng)
        self.problem = StraightProblem.of(ROBOT, self.made.measured)
        self.truth = np.concatenate([TRUE.ravel(), self.made.home_lengths, self.made.poses.ravel()])
        self.starts = self.truth + rng.uniform(-OFF, OFF, (starts, len(self.truth)))

    def squares(self, x: np.ndarray) -> np.ndarray:
        """The residuals of Eq. 14, m^2: squared lengths of the model less those of encoders and home lengths."""
        lengths = self.problem.lengths(x[:16], x[16:].reshape(-1, 3))
        return np.ravel(lengths**2 - (self.made.measured.counted + x[12:16]) ** 2)

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Eq. 26: 2 l u, -2 l u and -2 (dl + l0)."""
        poses = x[16:].reshape(-1, 3)
        found = self.problem.derivatives(x[:16], poses)
        n, m = len(poses), ROBOT.m
        sigma = self.problem.encoder_sigma
        lengths, home = self.problem.lengths(x[:16], poses), self.made.measured.counted + x[12:16]
        out = np.zeros((n, m, len(x)))
        out[:, :, :12] = 2.0 * sigma * lengths[..., None] * found.by_unknown[..., :12]
        out[:, range(m), 12 + np.arange(m)] = -2.0 * home
        for j in range(n):
            out[j, :, 16 + 3 * j : 19 + 3 * j] = 2.0 * sigma * lengths[j, :, None] * found.by_pose[j]
        return out.reshape(n * m, -1)

    def mu(self, x: np.ndarray) -> float:
        """Eq. 21, mm^2."""
        return 1e6 * float(np.abs(self.squares(x)).mean())

    def as_paper(self, start: np.ndarray, ftol: float | None, xtol: float, analytic: bool) -> np.ndarray:
        """A bounded trust-region solver of the same kind as the paper's, with its two tolerances."""
        how = self.jacobian if analytic else "2-point"
        bounds = self.truth - BOUND, self.truth + BOUND
        tolerances = {"ftol": ftol, "xtol": xtol, "gtol": None}
        return np.array(least_squares(self.squares, start, how, bounds, "trf", **tolerances, max_nfev=500).x)

    def ours(self) -> np.ndarray:
        """Where all starts end."""
        found = fits(self.problem, self.starts[:, :16], self.starts[:, 16:].reshape(len(self.starts), -1, 3))
        return np.array([np.append(each.theta, each.poses.ravel()) for each in found])


def tolerances(few: int) -> None:
    """The paper's Fig. 4: mu by FunctionTolerance and StepTolerance."""
    case = Case(20, few)
    print(f"mu in mm^2, 20 poses, mean of {few} starts, StepTolerance = FunctionTolerance")
    print("tolerance   with Jacobian   without")
    for tolerance in TOLERANCES:
        means = [
            np.mean([case.mu(case.as_paper(start, tolerance, tolerance, analytic)) for start in case.starts])
            for analytic in (True, False)
        ]
        print(f"{tolerance:9.0e} {means[0]:15.1e} {means[1]:9.1e}")


def by_poses(starts: int, few: int) -> tuple[list[float], list[float]]:
    """The paper's Figs. 5 and 6: mu and the error of the mean by the number of poses; and the error of each run."""
    print(f"\n{starts} starts: error of their mean, as in the paper, and of single runs; rms over exit points, mm")
    print("poses   mu, mm^2   mean of runs   predicted   one run   worst run, aligned")
    means, singles = [], []
    for count in POSES:
        case = Case(count, starts)
        found = case.ours()
        mu = np.mean([case.mu(x) for x in found])
        exits = found[:, :12].reshape(-1, 4, 3)
        mean = float(np.sqrt(np.mean((exits.mean(axis=0) - TRUE) ** 2)))
        single = float(np.sqrt(np.mean((exits - TRUE) ** 2)))
        worst = max(float(np.abs(cw.aligned(each, TRUE)[0] - TRUE).max()) for each in exits)
        predicted = single / np.sqrt(starts)
        print(
            f"{count:5} {mu:10.1e} {1e3 * mean:14.3f} {1e3 * predicted:11.3f} {1e3 * single:9.2f} {1e3 * worst:16.1e}"
        )
        means.append(1e3 * mean)
        singles.append(1e3 * single)
    case = Case(40, few)
    print(f"\ntime of a start, 40 poses, median of {few} in turn; the paper: 4327 s with Jacobian, 17278 s without")
    times: dict[bool, list[float]] = {True: [], False: []}
    for start in case.starts:
        for analytic, own in times.items():
            begin = time.perf_counter()
            case.as_paper(start, 1e-8, 1e-8, analytic)
            own.append(time.perf_counter() - begin)
    for name, analytic in (("bounded trust region, with Jacobian", True), ("without", False)):
        print(f"{name:<38} {1e3 * np.median(times[analytic]):8.2f} ms")
    case = Case(40, starts)
    begin = time.perf_counter()
    case.ours()
    print(f"{'cablewright, poses eliminated':<38} {1e3 * (time.perf_counter() - begin) / starts:8.2f} ms")
    return means, singles


def separately(few: int) -> None:
    """The paper's Fig. 4: each of the two tolerances varies while the other one has the paper's own value."""
    case = Case(20, few)
    print(f"mu in mm^2, 20 poses, mean of {few} starts, with Jacobian")
    print("the other tolerance: StepTolerance 1e-12, FunctionTolerance off")
    print("tolerance   FunctionTolerance varies   StepTolerance varies")
    for tolerance in TOLERANCES:
        pairs = ((tolerance, 1e-12), (None, tolerance))
        means = [np.mean([case.mu(case.as_paper(start, *pair, True)) for start in case.starts]) for pair in pairs]
        print(f"{tolerance:9.0e} {means[0]:26.1e} {means[1]:22.1e}")


def first_exit(starts: int) -> None:
    """The paper's Fig. 6: error of the y coordinate of the first exit point, by the number of poses."""
    print(f"\ny of the first exit point, mm: error of the mean of {starts} runs, and rms error of a single run")
    for count in POSES:
        case = Case(count, starts)
        y = np.array([x[1] for x in case.ours()]) - TRUE[0, 1]
        print(f"{count:5} {1e3 * y.mean():8.3f} {1e3 * float(np.sqrt(np.mean(y**2))):8.2f}")


def picture(file: Path, means: list[float], singles: list[float], starts: int) -> None:
    """Both errors by the number of poses, as .png, .svg or .pdf, with the data beside it."""
    from cablewright.apps import style
    from cablewright.apps.pictures.gallery import save

    path = style.picture_file(file)
    with style.drawing():
        drawn = style.figure(6.4, 3.6)
        axes = drawn.add_subplot()
        axes.semilogy(POSES, singles, "o-", color=style.ORANGE, label="a single run")
        axes.semilogy(POSES, means, "s-", color=style.BLUE, label=f"mean of {starts} runs, as in the paper")
        scaled = np.array(singles) / np.sqrt(starts)
        axes.semilogy(POSES, scaled, "--", color=style.INK, label=f"a single run / √{starts}")
        axes.axhline(0.1, color=style.GREY, linewidth=1.0)
        axes.annotate("the paper's 0.1 mm", (POSES[-1], 0.1), xytext=(0, 4), textcoords="offset points", ha="right")
        axes.set(xlabel="poses", ylabel="error of exit points, rms, in mm", ylim=(0.02, 20.0))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.set_title("no noise, not aligned: what is averaged is the start")
        drawn.legend(loc="outside lower center", ncols=3)
        save(drawn, path)


def main() -> None:
    """All of it, or with --figures Figs. 4 and 6 alone; --few is the number of starts of the slow solvers."""
    options = argparse.ArgumentParser()
    options.add_argument("--starts", type=int, default=500)
    options.add_argument("--few", type=int, default=20)
    options.add_argument("--plot", type=Path)
    options.add_argument("--figures", action="store_true")
    given = options.parse_args()
    if given.figures:
        separately(given.few)
        first_exit(given.starts)
        return
    tolerances(given.few)
    means, singles = by_poses(given.starts, given.few)
    if given.plot is not None:
        picture(given.plot, means, singles, given.starts)


if __name__ == "__main__":
    main()
