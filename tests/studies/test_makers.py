"""What owners of small printers, plotters and routers ask: corners by the strand, zeroed lines, G-code of a plane."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cablewright.apps.cli.main import run
from cablewright.exchange.formats import read_robot
from cablewright.foundation.errors import InputError
from cablewright.foundation.units import Vec3
from cablewright.models.job_poses import on_plane
from cablewright.models.statics import Model
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load, loads
from cablewright.robot.plane import Plane
from cablewright.robot.uncertainty import Uncertainty, assumed_uncertainty
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.parameter_effects import at_nozzle, range_response, response
from cablewright.studies.accuracy import accuracy
from cablewright.studies.accuracy_at_pose import AccuracyAtPose
from cablewright.studies.checks.check import check
from cablewright.studies.part_fit import fit
from cases import some

WALL = """
kinematics:
  WallPlotter:
    left_anchor_x: -500
    left_anchor_y: 400
    right_anchor_x: 500
    right_anchor_y: 400
"""
SQUARE = "G21\nG90\nG0 Z5\nG0 X-100 Y-100 F2400\nG1 Z0\nG1 X100 F1200\nG1 Y100\nG1 X-100\nG1 Y-100\nG0 Z5\n"


def ring(radius: float, layers: int, height: float = 0.3, width: float | None = None) -> str:
    """A ring of layers, mm, as a slicer writes it; E in mm of a filament of 1.75 mm."""
    text = "G21\nG90\nM82\n" + (f";WIDTH:{width}\n" if width else "")
    e = 0.0
    for k in range(layers):
        text += f";LAYER:{k}\nG0 X{radius:.3f} Y0 Z{(k + 1) * height:.3f} F6000\n"
        for i in range(1, 37):
            e += 0.05
            x, y = (radius * f(math.tau * i / 36) for f in (math.cos, math.sin))
            text += f"G1 X{x:.3f} Y{y:.3f} E{e:.4f} F1800\n"
    return text


class TestCorners:
    """Corners without a deviation of their own are rounded by a twelfth of the strand's width."""

    @pytest.mark.parametrize(("width", "corner"), [(0.6, 5e-5), (1.2, 1e-4), (None, 7.5e-5)])
    def test_by_the_strand(self, width: float | None, corner: float, tmp_path: Path) -> None:
        (tmp_path / "ring.gcode").write_text(ring(20.0, 2, width=width))
        job = load_job(tmp_path / "ring.gcode")
        found = job.with_corners(job.beads(job.toolpath()))
        assert found.motion.corner == pytest.approx(corner)
        assert found.with_corners(job.beads(job.toolpath())) is found

    def test_never_more_than_of_the_assumed_strand(self) -> None:
        helix = {"radius": 1.0, "layers": 1, "layer_height": 0.1}
        job = Job.model_validate({"name": "h", "helix": helix, "bead": {"width": 0.5, "height": 0.1}})
        assert job.with_corners(job.beads(job.toolpath())).motion.corner == pytest.approx(5e-3)
        assert job.motion.corner == pytest.approx(5e-3)

    def test_values_of_the_job_stay(self) -> None:
        helix = {"radius": 1.0, "layers": 1, "layer_height": 0.1}
        job = Job.model_validate({"name": "h", "helix": helix, "motion": {"corner_deviation": 0.003}})
        assert job.with_corners(job.beads(job.toolpath())).motion.corner_deviation == 0.003


@pytest.mark.parametrize("name", some(["hangprinter-v4", "hangprinter-five"]))
def test_a_hangprinter_prints_a_small_ring(name: str, tmp_path: Path) -> None:
    (tmp_path / "ring.gcode").write_text(ring(25.0, 1))
    found = check(load(name), tmp_path / "ring.gcode")
    assert found.feasible, found.verdict
    assert found.nearest is not None
    assert found.nearest.margin > 0.05
    assert found.expected is not None
    assert found.expected.value < 2.5e-4
    assert any("zeroed_at" in note for note in found.notes)


@pytest.mark.slow  # as `test_nothing_solved` in apps/report/test_check.py
def test_gcode_of_another_bed_is_answered_with_a_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The zero of its bed is at a corner, some metres away: no pose is held, and the pictures are drawn."""
    text = "G21\nG90\nM83\n;LAYER:0\nG0 X4000 Y4000 Z0.6 F3000\nG1 X4200 Y4000 E9 F1800\nG1 X4200 Y4200 E9\n"
    (tmp_path / "part.gcode").write_text(text)
    out = tmp_path / "out"
    assert run(["check", "hangprinter-v4", str(tmp_path / "part.gcode"), "--out", str(out), "--no-interference"]) == 1
    assert "out of bounds" in capsys.readouterr().err
    assert (out / "report.html").stat().st_size > 20_000


class TestZeroed:
    """Where lines are zeroed the nozzle is exact, whatever exit points are; errors grow with the distance."""

    def of(self, robot: Robot, radius: float, tmp_path: Path) -> float:
        (tmp_path / "ring.gcode").write_text(ring(radius, 1))
        found = check(robot, tmp_path / "ring.gcode", skip=("interference",))
        assert found.expected is not None
        return found.expected.value

    @pytest.mark.slow  # no fast test has its figures; that it is zero where lines are zeroed is below
    def test_it_grows_with_the_distance(self, tmp_path: Path) -> None:
        robot = load("hangprinter-v4")
        small, large = (self.of(robot, radius, tmp_path) for radius in (20.0, 200.0))
        absolute = self.of(robot.model_copy(update={"uncertainty": assumed_uncertainty(robot)}), 20.0, tmp_path)
        assert 5.0 * small < large < 20.0 * small
        assert absolute > 10.0 * small

    def test_ranges_say_what_zeroing_pays_out(self) -> None:
        robot = load("hangprinter-v4")
        assert robot.uncertainty is not None
        ranges = robot.uncertainty.of(robot)
        line = robot.lines[0]
        away = np.array(line.platform_point) - line.exit_point
        for axis, name in enumerate("xyz"):
            each = next(r for r in ranges if (r.parameter.kind, r.parameter.line) == (f"exit_point.{name}", line.name))
            assert each.zeroing == pytest.approx([-2.0 * away[axis] / np.linalg.norm(away), 0.0, 0.0, 0.0])
        assert {each.zeroing for each in ranges if each.parameter.kind == "modulus"} == {(0.0,) * 4}

    @pytest.mark.parametrize(
        ("robot", "place"),
        [("house-printer", (0.0, 0.0, 5.0)), ("ipanema", (0.0, 0.0, 0.7)), ("hangprinter-v4", (0.0, 0.0, 0.0))],
    )
    @pytest.mark.parametrize("name", ["exit_point", "platform_point", "length_scale"])
    def test_the_nozzle_stays_where_lines_are_zeroed(self, robot: str, place: Vec3, name: str) -> None:
        """With winches on the floor, a nozzle below the platform, an advantage of 2."""
        model = Model.full(load(robot))
        if name == "platform_point" and model.n == 3:
            return
        parameters = [{"name": name, "deviation": 1e-3}]
        of = Uncertainty.model_validate({"zeroed_at": list(place), "parameters": parameters}).of(model.robot)
        held = solve_inverse(model, model.unrotated_at(np.array([place])))
        assert held.ok.all()
        left = np.abs(at_nozzle(held, range_response(held, of)))
        otherwise = np.abs(at_nozzle(held, response(held, [each.parameter for each in of])))
        assert left.max() < 6e-3 * otherwise.max()

    def test_tensions_at_a_pose_are_those_of_zeroed_lines(self) -> None:
        robot, place = load("hangprinter-v4"), (0.0, 0.0, 0.0)
        entry = {"name": "exit_point", "lines": [robot.lines[0].name], "plus_minus": 0.002}
        zeroed, absolute = (
            accuracy(robot, place, Uncertainty.model_validate({"parameters": [entry], **given}).of(robot),
                     method="first-order")
            for given in ({"zeroed_at": list(place)}, {})
        )  # fmt: skip
        assert isinstance(zeroed, AccuracyAtPose)
        assert isinstance(absolute, AccuracyAtPose)
        assert (zeroed.tension_deviation < 0.01 * absolute.tension_deviation).all()

    def test_a_file_may_give_the_place_alone(self) -> None:
        alone = Uncertainty.model_validate({"zeroed_at": [0.0, 0.0, "10 mm"]})
        robot = load("hangprinter-v4")
        assert len(alone.of(robot)) == len(assumed_uncertainty(robot).of(robot))


class TestPlane:
    """G-code in the plane's own X and Y, whose Z moves the tool."""

    def wall(self, folder: Path) -> Robot:
        (folder / "wall.yaml").write_text(WALL)
        return read_robot([folder / "wall.yaml"]).robot

    def job(self, folder: Path, **given: object) -> Job:
        (folder / "square.nc").write_text(SQUARE)
        return Job.model_validate(
            {"name": "square", "gcode": folder / "square.nc", "material": "every G1", "max_error": 0.005} | given
        )

    def test_a_wall_plotter_draws_a_square(self, tmp_path: Path) -> None:
        found = check(self.wall(tmp_path), self.job(tmp_path), skip=("interference",))
        assert found.feasible, found.verdict
        laid = found.samples.positions[found.samples.extruding]
        assert np.ptp(laid, axis=0) == pytest.approx([0.2, 0.0, 0.2], abs=1e-9)
        assert found.samples.extruded_length == pytest.approx(0.8, abs=1e-2)  # corners are rounded

    def test_a_board_that_leans_or_lies(self, tmp_path: Path) -> None:
        for vertical in ("true", "false"):
            text = f"Maslow_vertical: {vertical}\nMaslow_tlX: 0\nMaslow_tlY: 2000\nMaslow_trX: 3000\nMaslow_trY: 2000\n"
            (tmp_path / "maslow.yaml").write_text(
                text + "Maslow_blX: 0\nMaslow_blY: 0\nMaslow_brX: 3000\nMaslow_brY: 0\n"
            )
            robot = read_robot([tmp_path / "maslow.yaml"]).robot
            job = on_plane(robot, self.job(tmp_path))
            samples = job.samples(job.toolpath())
            plane = robot.platform.plane
            assert plane is not None
            assert max(abs(plane.height(at)) for at in samples.positions) < 1e-12
            assert np.linalg.norm(samples.positions.mean(axis=0) - job.origin) < 0.1
            assert samples.positions[:, 2].max() > 1.0 if vertical == "true" else not samples.positions[:, 2].any()

    def test_coordinates_of_a_job_stay(self, tmp_path: Path) -> None:
        robot = self.wall(tmp_path)
        assert on_plane(robot, self.job(tmp_path, origin=(0.1, 0.0, -0.2))).origin == (0.1, 0.0, -0.2)
        given = self.job(tmp_path, axes=[[1, 0, 0], [0, 0, 1]])
        assert on_plane(robot, given) is given
        with pytest.raises(ValueError, match="two unit vectors at right angles"):
            self.job(tmp_path, axes=[[1, 0, 0], [1, 0, 0]])

    def test_directions_by_hand(self) -> None:
        s, c = math.sin(math.radians(15)), math.cos(math.radians(15))
        for normal, one_sided, right, up in (
            ((0, -1, 0), False, (1, 0, 0), (0, 0, 1)),
            ((0, 1, 0), False, (1, 0, 0), (0, 0, 1)),
            ((0, 1, 0), True, (-1, 0, 0), (0, 0, 1)),
            ((0, 0, 2), True, (1, 0, 0), (0, 1, 0)),
            ((0, -c, s), True, (1, 0, 0), (0, s, c)),
            ((-1, 0, 0), True, (0, -1, 0), (0, 0, 1)),
        ):
            plane = Plane.model_validate({"normal": [float(each) for each in normal], "one_sided": one_sided})
            assert plane.directions[0] == pytest.approx(right)
            assert plane.directions[1] == pytest.approx(up)

    def test_a_zero_off_the_plane(self) -> None:
        with pytest.raises(ValueError, match=r"gcode_zero.*0\.1 m off the plane"):
            Plane.model_validate({"normal": [0.0, 0.0, 1.0], "gcode_zero": [0.0, 0.0, 0.1]})

    def test_it_fits_a_wall_anywhere(self, tmp_path: Path) -> None:
        found = fit(self.wall(tmp_path), self.job(tmp_path))
        assert found.scale > 2.0
        assert found.size == pytest.approx([0.2, 0.0, 0.2])


def test_a_part_fits_a_frame_that_begins_above_the_floor(tmp_path: Path) -> None:
    (tmp_path / "ring.gcode").write_text(ring(25.0, 3))
    robot = load("hangprinter-v4")
    low = robot.scene.model_copy(update={"frame_min": (-1.5, -1.7, 0.3)})
    found = fit(robot.model_copy(update={"scene": low}), load_job(tmp_path / "ring.gcode"))
    assert found.fits
    assert found.origin[2] == pytest.approx(0.3 - 3e-4, abs=1e-4)


def test_a_robot_file_without_any_uncertain_number_is_rejected() -> None:
    with pytest.raises(InputError, match="parameters"):
        loads('schema = 1\nname = "x"\n[uncertainty]\nname = "none"\n')
