"""Make the problems of `cablewright.problems` with their answers: python -m benchmarks.problems.answers.

Nothing here computes with cablewright: answers are of mpmath with 50 digits, of linear programs by HiGHS, of quadratic
ones by trying all active sets, of four million random places, or known because the data were made from them.
"""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
from mpmath import mp, mpf
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

FILE = Path(__file__).resolve().parents[2] / "src" / "cablewright" / "studies" / "problems.json"
GRAVITY = 9.81  # m/s^2
SAMPLES = 4_000_000  # random places of a volume
QUESTIONS = {
    "forward": "Where does a point hang on cables of these unstrained lengths?",
    "tensions": "Which tensions of least sum of squares within the limits hold the body?",
    "acceleration": "How fast can it accelerate along a direction, at rest, without turning?",
    "margin": "How far is the weight from the nearest facet of the available forces?",
    "volume": "How large is the region where tensions within the limits hold the weight?",
    "calibration": "How far apart are the exit points, by lengths counted at unknown places?",
    "frequencies": "Which natural frequencies has it at rest on cables of these unstrained lengths?",
}


def box(x: float, y: float, z: float) -> np.ndarray:
    """Four exit points around a rectangle of half widths x and y, m, at a height."""
    return np.array([[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]])


TRIANGLE = np.array([[0.0, 4.0, 5.0], [-3.5, -2.0, 5.0], [3.5, -2.0, 5.0]])
EIGHT = np.vstack([box(2.0, 1.5, 3.0), box(2.0, 1.5, 0.2)])
BODY = np.vstack([box(0.1, 0.3, -0.2), box(0.1, 0.3, 0.2)])  # crossed


def away(exits: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return unit vectors (m, 3) from platform points to exit points, and distances (m,), m."""
    way = exits - ends
    length = np.linalg.norm(way, axis=1)
    return way / length[:, None], length


def structure(exits: np.ndarray, points: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Return the structure matrix (6, m) of straight cables."""
    arms = Rotation.from_rotvec(pose[3:]).apply(points)
    unit, _ = away(exits, pose[:3] + arms)
    return np.vstack([unit.T, np.cross(arms, unit).T])


def problem(name: str, kind: str, inputs: dict[str, Any], answer: Any, tolerance: float, **more: Any) -> dict[str, Any]:
    """Return one problem as the file has it; *tolerance*: in the unit of the answer."""
    plain = {key: np.asarray(value).tolist() if not isinstance(value, str) else value for key, value in inputs.items()}
    return {
        "name": name,
        "kind": kind,
        "question": QUESTIONS[kind],
        "inputs": plain,
        "answer": np.asarray(answer).tolist(),
        "tolerance": tolerance,
        **more,
    }


def span(H: mpf, V0: mpf, L: mpf, w: mpf, EA: mpf) -> tuple[mpf, mpf]:
    """Irvine's elastic span of unstrained length L: its end from its start, where the tension vector is (H, V0)."""
    V1 = V0 + w * L
    x = H * L / EA + H / w * (mp.asinh(V1 / H) - mp.asinh(V0 / H))
    z = V0 * L / EA + w * L**2 / (2 * EA) + (mp.hypot(H, V1) - mp.hypot(H, V0)) / w
    return x, z


@mp.workdps(50)
def sagging(
    name: str, exits: np.ndarray, place: list[float], mass: float, EA: float, density: float, spare: list[float]
) -> dict[str, Any]:
    """Lengths that hold a point at *place*; *spare*: N, horizontal tensions of the lines beyond three."""
    m, w, weight = len(exits), mpf(density) * mpf(GRAVITY), mpf(mass) * mpf(GRAVITY)
    p = np.array(place)
    ways = [[mpf(float(b)) - mpf(float(a)) for a, b in zip(row, p, strict=True)] for row in exits]
    level = [mp.hypot(x, y) for x, y, _ in ways]
    unit, length = away(exits, p)
    first = np.zeros(m)
    first[3:] = np.array(spare) * length[3:] / np.array([float(d) for d in level[3:]])
    first[:3] = np.linalg.solve(unit[:3].T, [0.0, 0.0, float(weight)] - unit[3:].T @ first[3:])

    def miss(*u: mpf) -> list[mpf]:
        H = [*u[:3], *(mpf(each) for each in spare)]
        V, L = u[3 : 3 + m], u[3 + m :]
        ends = [span(H[i], V[i], L[i], w, mpf(EA)) for i in range(m)]
        out = [ends[i][0] - level[i] for i in range(m)] + [ends[i][1] - ways[i][2] for i in range(m)]
        out += [sum(H[i] * ways[i][k] / level[i] for i in range(m)) for k in (0, 1)]
        return [*out, sum(-(V[i] + w * L[i]) for i in range(m)) - weight]

    guess = [first[i] * float(level[i]) / length[i] for i in range(3)]
    guess += [first[i] * float(ways[i][2]) / length[i] for i in range(m)] + [1.0005 * each for each in length]
    found = mp.findroot(miss, guess, tol=mpf(10) ** -70, maxsteps=200)
    assert min(found[:3]) > 0, name  # no cable pushes
    lengths = [float(each) for each in found[3 + m :]]
    inputs = {"exit_points": exits, "mass": mass, "axial_stiffness": EA, "linear_density": density, "lengths": lengths}
    return problem(
        name,
        "forward",
        inputs,
        place,
        1e-8,
        unit="m",
        oracle="mpmath, 50 digits: Irvine's elastic catenaries and the balance of forces",
    )


def forwards() -> list[dict[str, Any]]:
    """Return points on sagging cables."""
    steel, dyneema = {"EA": 1.28e6, "density": 0.03}, {"EA": 7.07e5, "density": 0.0068}
    return [
        sagging("forward-room-3", TRIANGLE, [0.5, 0.3, 1.5], 20.0, spare=[], **dyneema),
        sagging("forward-room-4", box(2.2, 4.4, 3.0), [0.4, -1.0, 1.2], 40.0, spare=[80.0], **dyneema),
        sagging("forward-low-pretension", box(2.2, 4.4, 3.0), [0.5, -0.5, 1.0], 40.0, spare=[8.0], **dyneema),
        sagging("forward-hall-steel", box(7.5, 7.5, 15.0), [2.0, -3.0, 5.0], 200.0, spare=[400.0], **steel),
        sagging("forward-hall-high", box(7.5, 7.5, 15.0), [0.0, 0.0, 13.25], 200.0, spare=[2500.0], **steel),
        sagging("forward-stadium", box(60.0, 40.0, 45.0), [20.0, 10.0, 12.0], 60.0, 3e6, 0.05, [500.0]),
        sagging("forward-heavy-cable", box(15.0, 15.0, 20.0), [3.0, 2.0, 6.0], 80.0, 5e6, 0.6, [250.0]),
        sagging("forward-soft-cable", box(2.2, 4.4, 3.0), [0.0, 1.0, 1.4], 30.0, 2e4, 0.01, [90.0]),
    ]


def least_squares_tensions(A: np.ndarray, wrench: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return min |t|^2 with A t = wrench and low <= t <= high, by trying all sets of lines at a limit."""
    best: np.ndarray | None = None
    n, m = A.shape
    for count in range(m - n + 1):
        for fixed in itertools.combinations(range(m), count):
            for ends in itertools.product((low, high), repeat=count):
                t = np.zeros(m)
                t[list(fixed)] = ends
                free = [i for i in range(m) if i not in fixed]
                t[free] = np.linalg.lstsq(A[:, free], wrench - A @ t, rcond=None)[0]
                held = np.abs(A @ t - wrench).max() < 1e-9 and t.min() > low - 1e-9 and t.max() < high + 1e-9
                if held and (best is None or t @ t < best @ best - 1e-12):
                    best = t
    assert best is not None
    return best


def tensions() -> list[dict[str, Any]]:
    """Return tension distributions of a body on eight cables."""
    cases = [
        ("centre", [0.0, 0.0, 1.5], 50.0, 800.0),
        ("corner", [1.2, 0.9, 2.2], 20.0, 800.0),
        ("turned", [0.3, 0.2, 1.5, 0.1, -0.1, 0.3], 20.0, 800.0),
        ("low", [-0.8, 0.5, 0.6, 0, 0, 0.1], 40.0, 400.0),
    ]
    out = []
    for name, pose, low, high in cases:
        at = np.array([*pose, *np.zeros(6 - len(pose))])
        t = least_squares_tensions(structure(EIGHT, BODY, at), np.array([0, 0, 10.0 * GRAVITY, 0, 0, 0]), low, high)
        inputs = {
            "exit_points": EIGHT,
            "platform_points": BODY,
            "mass": 10.0,
            "pose": at,
            "tension_limits": [low, high],
        }
        out.append(
            problem(
                f"tensions-{name}", "tensions", inputs, t, 1e-6, unit="N", oracle="NumPy: all sets of lines at a limit"
            )
        )
    return out


def accelerations() -> list[dict[str, Any]]:
    """Return largest accelerations of a point and of a body."""
    out = []
    cases = [
        ("point-up", None, [0.4, -1.0, 1.2], [0, 0, 1]),
        ("point-side", None, [0.4, -1.0, 1.2], [1, 0, 0]),
        ("body-up", BODY, [0.3, 0.2, 1.5, 0, 0, 0], [0, 0, 1]),
        ("body-side", BODY, [0.3, 0.2, 1.5, 0, 0, 0.2], [0.6, 0.8, 0]),
    ]
    for name, points, pose, direction in cases:
        exits, mass, limits = (
            (box(2.2, 4.4, 3.0), 40.0, (10.0, 800.0)) if points is None else (EIGHT, 10.0, (20.0, 800.0))
        )
        at, d = np.array(pose, dtype=float), np.array(direction, dtype=float)
        A = away(exits, at)[0].T if points is None else structure(exits, points, at)
        push = np.zeros(len(A))
        push[:3] = mass * d
        weight = np.zeros(len(A))
        weight[2] = mass * GRAVITY
        found = linprog(
            [*np.zeros(len(exits)), -1.0],
            A_eq=np.hstack([A, -push[:, None]]),
            b_eq=weight,
            bounds=[*[limits] * len(exits), (0, None)],
            method="highs",
        )
        inputs = {"exit_points": exits, "mass": mass, "pose": at, "direction": d, "tension_limits": limits}
        inputs |= {} if points is None else {"platform_points": points}
        out.append(
            problem(
                f"acceleration-{name}",
                "acceleration",
                inputs,
                [found.x[-1]],
                1e-6,
                unit="m/s^2",
                oracle="SciPy: a linear program by HiGHS",
            )
        )
    return out


def margins() -> list[dict[str, Any]]:
    """Return distances of the weight from the boundary of the available forces of a point."""
    out = []
    for name, place in (("middle", [0.0, 0.0, 1.0]), ("side", [1.5, 3.0, 1.6])):
        exits, low, high = box(2.2, 4.4, 3.0), 10.0, 800.0
        unit = away(exits, np.array(place))[0]
        force = np.array([0.0, 0.0, 40.0 * GRAVITY])
        near = np.inf
        for i, j in itertools.combinations(range(4), 2):
            for sign in (1.0, -1.0):
                n = sign * np.cross(unit[i], unit[j])
                n /= np.linalg.norm(n)
                near = min(near, np.maximum(low * unit @ n, high * unit @ n).sum() - n @ force)
        inputs = {"exit_points": exits, "mass": 40.0, "pose": place, "tension_limits": [low, high]}
        out.append(
            problem(
                f"margin-{name}",
                "margin",
                inputs,
                [near],
                1e-6,
                unit="N",
                oracle="NumPy: all pairs of cables as facets",
            )
        )
    return out


def volumes() -> list[dict[str, Any]]:
    """Return workspaces: by random places."""
    out, random = [], np.random.default_rng(2023)
    cases = [
        ("room-3", TRIANGLE, [[-3.5, -2.0, 0.0], [3.5, 4.0, 5.0]], 20.0, (5.0, 400.0)),
        ("room-4", box(2.2, 4.4, 3.0), [[-2.2, -4.4, 0.0], [2.2, 4.4, 3.0]], 40.0, (20.0, 600.0)),
        ("hall-4", box(7.5, 7.5, 15.0), [[-7.5, -7.5, 0.0], [7.5, 7.5, 15.0]], 200.0, (510.0, 5150.0)),
        ("hall-4-wide", box(7.5, 7.5, 15.0), [[-7.5, -7.5, 0.0], [7.5, 7.5, 15.0]], 200.0, (20.0, 5150.0)),
    ]
    for name, exits, frame, mass, (low, high) in cases:
        inside, (lower, upper) = 0, np.array(frame)
        for _ in range(SAMPLES // 500_000):
            places = random.uniform(lower, upper, (500_000, 3))
            way = exits - places[:, None]
            unit = way / np.linalg.norm(way, axis=2, keepdims=True)
            base = np.linalg.solve(unit[:, :3].transpose(0, 2, 1), np.array([0, 0, mass * GRAVITY])[:, None])[..., 0]
            if len(exits) == 3:
                inside += int(((base >= low) & (base <= high)).all(axis=1).sum())
                continue
            change = -np.linalg.solve(unit[:, :3].transpose(0, 2, 1), unit[:, 3, :, None])[
                ..., 0
            ]  # for 1 N of the fourth
            ends = (np.array([low, high]) - base[..., None]) / change[..., None]
            least = np.maximum(ends.min(axis=2).max(axis=1), low)
            most = np.minimum(ends.max(axis=2).min(axis=1), high)
            inside += int((least <= most).sum())
        size, share = float(np.prod(upper - lower)), inside / SAMPLES
        sigma = size * float(np.sqrt(share * (1.0 - share) / SAMPLES))
        inputs = {"exit_points": exits, "mass": mass, "frame": frame, "tension_limits": [low, high]}
        out.append(
            problem(
                f"volume-{name}",
                "volume",
                inputs,
                [size * share],
                4.0 * sigma + 4e-3 * size * share,
                unit="m^3",
                oracle=f"NumPy: {SAMPLES} random places, sigma {sigma:.2g} m^3",
            )
        )
    return out


def calibrations() -> list[dict[str, Any]]:
    """Return counted lengths without noise, and the distances between the exit points that they were made of."""
    out = []
    for name, exits, count in (
        ("12-poses", box(2.2, 4.4, 3.0), 12),
        ("20-poses", box(2.2, 4.4, 3.0), 20),
        ("40-poses", box(7.5, 7.5, 15.0), 40),
        ("uneven", TRIANGLE[[0, 1, 2, 2]] + [[0, 0, 0], [0, 0, 0.4], [0, 0, 0], [0.5, 5.0, -0.3]], 24),
    ):
        random = np.random.default_rng(count)
        true = exits + random.uniform(-0.02, 0.02, exits.shape)
        low, high = exits.min(axis=0) * 0.6, exits.max(axis=0) * 0.6
        low[2], high[2] = 0.2 * exits[:, 2].min(), 0.7 * exits[:, 2].min()
        places = random.uniform(low, high, (count, 3))
        lengths = np.linalg.norm(true - places[:, None], axis=2)
        guess = places + random.uniform(-0.01, 0.01, places.shape)
        pairs = itertools.combinations(true, 2)
        inputs = {"exit_points": exits, "counted": lengths - lengths[0], "guess": guess}
        out.append(
            problem(
                f"calibration-{name}",
                "calibration",
                inputs,
                [np.linalg.norm(a - b) for a, b in pairs],
                1e-6,
                unit="m",
                oracle="known: the data were made from it, without noise",
            )
        )
    return out


@mp.workdps(50)
def frequencies() -> list[dict[str, Any]]:
    """Return natural frequencies on straight cables, by second differences of the energy with 50 digits."""
    out = []
    cases = [
        ("point-3", TRIANGLE, None, [0.5, 0.3, 1.5], 20.0, []),
        ("point-4", box(2.2, 4.4, 3.0), None, [0.4, -1.0, 1.2], 40.0, [150.0]),
        ("body-slack-side", EIGHT, BODY, [0.3, 0.2, 1.5, 0, 0, 0], 10.0, []),
        ("body-turned", EIGHT, BODY, [-0.4, 0.3, 1.8, 0.1, 0, 0.2], 10.0, []),
    ]
    EA, inertia = 7.07e5, [0.3, 0.4, 0.3]
    for name, exits, points, pose, mass, spare in cases:
        at = np.array(pose, dtype=float)
        if points is None:
            unit, length = away(exits, at)
            t = np.array([0.0, 0.0, 0.0, *spare])
            t[:3] = np.linalg.solve(unit[:3].T, [0, 0, mass * GRAVITY] - unit[3:].T @ t[3:])
        else:
            A = structure(exits, points, at)
            t = least_squares_tensions(A, np.array([0, 0, mass * GRAVITY, 0, 0, 0]), 20.0, 800.0)
            length = away(exits, at[:3] + Rotation.from_rotvec(at[3:]).apply(points))[1]
        rest = [mpf(float(one)) / (1 + mpf(float(pull)) / EA) for one, pull in zip(length, t, strict=True)]
        turned = Rotation.from_rotvec(at[3:]).as_matrix() if points is not None else np.eye(3)

        def energy(*u: mpf, exits=exits, points=points, at=at, rest=rest, turned=turned, mass=mass) -> mpf:
            """Return the energy after a translation and, of a body, a small rotation in space."""
            spin = mp.eye(3)
            if points is not None:
                x, y, z = u[3:]
                cross = mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                spin = mp.eye(3) + cross + cross**2 / 2
            total = mpf(mass) * mpf(GRAVITY) * u[2]
            for i, a in enumerate(exits):
                arm = [mpf(0)] * 3 if points is None else list(spin * mp.matrix((turned @ points[i]).tolist()))
                way = mp.sqrt(sum((mpf(float(a[k])) - mpf(float(at[k])) - u[k] - arm[k]) ** 2 for k in range(3)))
                total += mpf(EA) / (2 * rest[i]) * (way - rest[i]) ** 2
            return total

        n, h = len(at), mpf(10) ** -15
        K = np.zeros((n, n))
        for i, j in itertools.product(range(n), repeat=2):
            steps = [
                [(h * si if k == i else 0) + (h * sj if k == j else 0) for k in range(n)]
                for si, sj in ((1, 1), (1, -1), (-1, 1), (-1, -1))
            ]
            e = [energy(*(mpf(v) for v in one)) for one in steps]
            K[i, j] = float((e[0] - e[1] - e[2] + e[3]) / (4 * h * h))
        M = np.eye(3) * mass
        if points is not None:
            M = np.block([[M, np.zeros((3, 3))], [np.zeros((3, 3)), turned @ np.diag(inertia) @ turned.T]])
        squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, 0.5 * (K + K.T))).real)
        inputs = {
            "exit_points": exits,
            "mass": mass,
            "axial_stiffness": EA,
            "pose": at,
            "lengths": [float(each) for each in rest],
        }
        inputs |= {} if points is None else {"platform_points": points, "inertia": inertia}
        out.append(
            problem(
                f"frequencies-{name}",
                "frequencies",
                inputs,
                np.sqrt(squares) / (2.0 * np.pi),
                1e-5,
                unit="Hz",
                oracle="mpmath, 50 digits: second differences of the energy",
            )
        )
    return out


def main() -> None:
    """Write the file."""
    found = [*forwards(), *tensions(), *accelerations(), *margins(), *volumes(), *calibrations(), *frequencies()]
    assert len(found) == len({each["name"] for each in found}) == 30
    FILE.write_text(json.dumps({"schema": 1, "gravity": GRAVITY, "problems": found}, indent=1) + "\n", "utf-8")
    print(f"{FILE.name}: {len(found)} problems, {FILE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
