"""The thirty problems of `cablewright.problems`, solved by cablewright and by each peer that pip brings.

    python -m benchmarks.problems.peers

prints the table of docs/problems.md: the largest error of each kind of problem from the answer that comes with it, and
the median time of a solve, without that of building models. What is not installed is left out, with a line on stderr.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from importlib.metadata import version
from itertools import combinations, product

import numpy as np
from scipy.optimize import least_squares, linprog, minimize, root
from scipy.spatial import ConvexHull

import cablewright as cw
from benchmarks.timing import installed
from cablewright.foundation.arrays import Array

G = 9.81  # m/s^2
REPEATS = 5
Solve = Callable[[], Array]


def by_moorpy(problem: cw.Problem) -> Solve:
    """A point on MoorPy's elastic catenaries."""
    from moorpy.system import System

    given = problem.inputs
    w, EA = float(given["linear_density"]) * G, float(given["axial_stiffness"])
    system = System(depth=1000.0, rho=0.0, g=G)
    middle = given["exit_points"].mean(axis=0) - [0.0, 0.0, 0.5 * given["exit_points"][:, 2].min()]
    point = system.addPoint(0, middle, m=float(given["mass"]))
    for at, length in zip(given["exit_points"], given["lengths"], strict=True):
        fixed = system.addPoint(1, at)
        wire = {"name": "wire", "m": w / G, "w": w, "d_vol": 0.0, "EA": EA}
        system.addLine(length, wire, nSegs=1, pointA=fixed.number, pointB=point.number)
    system.initialize()

    def solve() -> Array:
        point.setPosition(middle)
        system.solveEquilibrium(tol=1e-9)
        return np.array(point.r)

    return solve


def by_root(problem: cw.Problem) -> Solve:
    """A point on Irvine's cables by SciPy's root, from straight cables at the middle of the exit points."""
    given = problem.inputs
    exits, L, m = given["exit_points"], given["lengths"], len(given["lengths"])
    w, EA, weight = float(given["linear_density"]) * G, float(given["axial_stiffness"]), float(given["mass"]) * G

    def miss(u: Array) -> Array:
        p, H, V0 = u[:3], u[3 : 3 + m] * weight, u[3 + m :] * weight
        way = p - exits
        level, V1 = np.hypot(way[:, 0], way[:, 1]), V0 + w * L
        x = H * L / EA + H / w * (np.arcsinh(V1 / H) - np.arcsinh(V0 / H))
        z = V0 * L / EA + w * L**2 / (2 * EA) + (np.hypot(H, V1) - np.hypot(H, V0)) / w
        pull = np.append((H / level) @ way[:, :2], -V1.sum() - weight) / weight
        return np.concatenate([x - level, z - way[:, 2], pull])

    def solve() -> Array:
        start = exits.mean(axis=0) - [0.0, 0.0, 0.5 * exits[:, 2].min()]
        way = start - exits
        first = np.concatenate([start, np.hypot(way[:, 0], way[:, 1]) / L, way[:, 2] / L])
        return np.asarray(root(miss, first, tol=1e-12).x[:3])

    return solve


def structure(problem: cw.Problem) -> tuple[Array, Array]:
    """The structure matrix, and the wrench that holds the weight."""
    A = cw.structure_matrix(problem.robot, problem.inputs["pose"])
    weight = np.zeros(len(A))
    weight[2] = float(problem.inputs["mass"]) * G
    return A, weight


def by_daqp(problem: cw.Problem) -> Solve:
    """Least-norm tensions by daqp."""
    import daqp

    A, weight = structure(problem)
    n, m = A.shape
    low, high = problem.inputs["tension_limits"]
    upper, lower = np.append(np.full(m, high), weight), np.append(np.full(m, low), weight)
    sense = np.append(np.zeros(m, dtype=np.int32), np.full(n, 5, dtype=np.int32)).astype(np.int32)
    hessian, linear, rows = np.eye(m), np.zeros(m), np.ascontiguousarray(A)
    return lambda: np.asarray(daqp.solve(hessian, linear, rows, upper, lower, sense)[0])


def by_slsqp(problem: cw.Problem) -> Solve:
    """Least-norm tensions by SciPy's SLSQP."""
    A, weight = structure(problem)
    low, high = problem.inputs["tension_limits"]
    held = {"type": "eq", "fun": lambda t: A @ t - weight, "jac": lambda _: A}
    start = np.full(A.shape[1], 0.5 * (low + high))
    options = {"maxiter": 500, "ftol": 1e-14}
    return lambda: np.asarray(
        minimize(
            lambda t: 0.5 * t @ t, start, jac=lambda t: t, method="SLSQP", bounds=[(low, high)] * len(start),
            constraints=[held], options=options,
        ).x
    )  # fmt: skip


def by_highs(problem: cw.Problem) -> Solve:
    """The largest acceleration by a linear program of SciPy."""
    A, weight = structure(problem)
    push = np.zeros(len(A))
    push[:3] = float(problem.inputs["mass"]) * problem.inputs["direction"]
    bounds = [tuple(problem.inputs["tension_limits"])] * A.shape[1] + [(0, None)]
    cost, rows = np.append(np.zeros(A.shape[1]), -1.0), np.hstack([A, -push[:, None]])
    return lambda: np.array([linprog(cost, A_eq=rows, b_eq=weight, bounds=bounds, method="highs").x[-1]])


def by_hull(problem: cw.Problem) -> Solve:
    """The margin by the convex hull of all corners, by Qhull of SciPy."""
    A, weight = structure(problem)

    def solve() -> Array:
        corners = np.array(list(product(problem.inputs["tension_limits"], repeat=A.shape[1]))) @ A.T
        hull = ConvexHull(corners).equations
        return np.array([-(hull[:, :-1] @ weight + hull[:, -1]).max()])

    return solve


def by_least_squares(problem: cw.Problem) -> Solve:
    """Exit points, home lengths and places by SciPy's least_squares, with differences for the Jacobian."""
    counted, guess, exits = (problem.inputs[key] for key in ("counted", "guess", "exit_points"))
    m, n = len(exits), len(guess)

    def miss(x: Array) -> Array:
        a, home, p = x[: 3 * m].reshape(m, 3), x[3 * m : 4 * m], x[4 * m :].reshape(n, 3)
        return np.ravel(np.linalg.norm(a - p[:, None], axis=2) - home - counted)

    def solve() -> Array:
        home = (np.linalg.norm(exits - guess[:, None], axis=2) - counted).mean(axis=0)
        start = np.concatenate([exits.ravel(), home, guess.ravel()])
        found = least_squares(miss, start, method="trf", ftol=None, xtol=1e-14, gtol=None, max_nfev=200).x
        return np.array([np.linalg.norm(a - b) for a, b in combinations(found[: 3 * m].reshape(m, 3), 2)])

    return solve


def text(values: Iterable[float]) -> str:
    """Return numbers as an attribute of MuJoCo's XML."""
    return " ".join(f"{value:.17g}" for value in values)


def by_mujoco(problem: cw.Problem) -> Solve:
    """Frequencies of MuJoCo's springs along tendons, by differences of its forces at rest."""
    import mujoco

    given = problem.inputs
    points = given.get("platform_points", np.zeros_like(given["exit_points"]))
    pose, m = np.append(given["pose"], np.zeros(6 - len(given["pose"]))), len(points)
    angle = float(np.linalg.norm(pose[3:]))
    axis = pose[3:] / angle if angle else np.array([0.0, 0.0, 1.0])
    turned = text([math.cos(0.5 * angle), *math.sin(0.5 * angle) * axis])
    joints = "<freejoint/>" if len(given["pose"]) == 6 else "".join(
        f'<joint type="slide" axis="{text(row)}"/>' for row in np.eye(3)
    )  # fmt: skip
    sites = "".join(f'<site name="b{i}" pos="{text(row)}"/>' for i, row in enumerate(points))
    exits = "".join(f'<site name="a{i}" pos="{text(row)}"/>' for i, row in enumerate(given["exit_points"]))
    EA, L = float(given["axial_stiffness"]), given["lengths"]
    springs = "".join(
        f'<spatial stiffness="{EA / L[i]:.17g}" springlength="{L[i]:.17g}">'
        f'<site site="a{i}"/><site site="b{i}"/></spatial>'
        for i in range(m)
    )
    inertia = text(given.get("inertia", np.ones(3)))
    body = f'<body pos="{text(pose[:3])}" quat="{turned}">{joints}<inertial pos="0 0 0" mass="{float(given["mass"])}" '
    body += f'diaginertia="{inertia}"/>{sites}</body>'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 {-G}"/><worldbody>{exits}{body}</worldbody><tendon>{springs}</tendon></mujoco>'
    )

    def solve() -> Array:
        data, K, M = mujoco.MjData(model), np.zeros((model.nv, model.nv)), np.zeros((model.nv, model.nv))
        for k, sign in product(range(model.nv), (1.0, -1.0)):
            mujoco.mj_resetData(model, data)
            mujoco.mj_integratePos(model, data.qpos, sign * np.eye(model.nv)[k], 1e-5)
            mujoco.mj_forward(model, data)
            K[:, k] -= sign * (data.qfrc_passive - data.qfrc_bias) / 2e-5
        mujoco.mj_resetData(model, data)
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, M)
        squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
        return np.asarray(np.sqrt(squares) / (2.0 * np.pi))

    return solve


PEERS: dict[str, list[tuple[str, str, Callable[[cw.Problem], Solve]]]] = {
    "forward": [("MoorPy", "moorpy", by_moorpy), ("SciPy root", "scipy", by_root)],
    "tensions": [("daqp", "daqp", by_daqp), ("SciPy SLSQP", "scipy", by_slsqp)],
    "acceleration": [("SciPy HiGHS", "scipy", by_highs)],
    "margin": [("SciPy Qhull", "scipy", by_hull)],
    "calibration": [("SciPy least_squares", "scipy", by_least_squares)],
    "frequencies": [("MuJoCo", "mujoco", by_mujoco)],
}
"""By kind of problem: the name of a peer, the package that it is of, and how it solves."""


def measured(problems: tuple[cw.Problem, ...], made: list[Solve]) -> tuple[float, int, float]:
    """The largest error, how many are within the tolerance, and the median time, s."""
    errors, times, good = [], [], 0
    for problem, solve in zip(problems, made, strict=True):
        solve()
        spent = []
        for _ in range(1 if problem.kind == "volume" else REPEATS):
            begin = time.perf_counter()
            answer = solve()
            spent.append(time.perf_counter() - begin)
        errors.append(problem.error(answer))
        good += errors[-1] <= problem.tolerance
        times.append(min(spent))
    return max(errors), good, float(np.median(times))


def rows() -> Iterator[tuple[str, ...]]:
    """Rows of the table."""
    for kind in dict.fromkeys(each.kind for each in cw.problems()):
        problems = cw.problems(kind)
        ours = [lambda problem=problem: problem.solve()[0] for problem in problems]
        everyone = [("cablewright", ours)]
        for name, package, make in PEERS.get(kind, []):
            if installed(package):
                everyone.append((name, [make(problem) for problem in problems]))
        for name, made in everyone:
            error, good, seconds = measured(problems, made)
            unit = problems[0].unit
            yield kind, name, f"{good} of {len(problems)}", f"{error:.1e} {unit}", f"{1e3 * seconds:.3g} ms"


def main() -> None:
    """Print the table, and the versions."""
    print("| kind | program | within the tolerance | largest error | time, median |")
    print("| --- | --- | --- | --- | --- |")
    for row in rows():
        print(f"| {' | '.join(row)} |", flush=True)
    found = [name for name in ("cablewright", "scipy", "moorpy", "daqp", "mujoco") if installed(name)]
    print("\n" + ", ".join(f"{name} {version(name)}" for name in found))
    print("MoorDyn is not compared: in air it does not come to rest, see docs/problems.md", file=sys.stderr)


if __name__ == "__main__":
    main()
