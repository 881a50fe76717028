"""Import of CASPR models, a file of bodies and one of cables: one body, cables of one span without stretch. All SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cablewright.exchange.assumed_values import BOX, Point, as_point, assumed_cable, chosen_cable, frame_of, name_of
from cablewright.exchange.translation_result import ImportedRobot, Mapped, Notes
from cablewright.exchange.xml_input import Element, number_or_none, read_xml
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.toml_input import is_file
from cablewright.foundation.validation import shown, validated
from cablewright.robot import Robot

BODIES, CABLES = "links", "cables"
ROOTS: Final = (BODIES, "bodies_system", CABLES)
"""Root elements of the two files; that of bodies may be within another."""

CARRIED: Final = (
    Mapped("link_rigid.name", "name"),
    Mapped(
        "joint.type", "platform.kind, plane",
        "SPATIAL_... a body, TRANSLATIONAL_... a point, PLANAR_XY, XZ, YZ a body and P_XY, XZ, YZ a point in a plane",
    ),
    Mapped("joint.q_min, q_max", "scene.frame_min, frame_max", "of positions; of angles they are lost"),
    Mapped("physical mass, com_location, inertia", "platform.mass, centre_of_mass, inertia, inertia_products"),
    Mapped("physical.end_location", "platform.nozzle"),
    Mapped("cable_ideal.name, force_min, force_max", "lines.name, tension_limits"),
    Mapped("attachment of link 0", "lines.exit_point", "an eyelet"),
    Mapped("attachment of link 1", "lines.platform_point", "from the joint or from the centre of mass, as it says"),
)  # fmt: skip

_SPATIAL = ("SPATIAL_EULER_XYZ", "SPATIAL_QUATERNION", "SPATIAL_QUATERNION_FIXED_XYZ")
_POINT = ("TRANSLATIONAL_XYZ",)
_NORMALS = {"XY": 2, "XZ": 1, "YZ": 0}
_PLANAR, _IN_A_PLANE = (tuple(f"{kind}_{axes}" for axes in _NORMALS) for kind in ("PLANAR", "P"))
_MOMENTS, _PRODUCTS = ("Ixx", "Iyy", "Izz"), ("Ixy", "Ixz", "Iyz")
_NOT_OF_A_ROBOT = ("links.display_range", "links.view_angle", "links.link_rigid.num", "links.link_rigid.parent.num")


def read_caspr(paths: Sequence[Path], cable_set: str | None = None, cable: str | None = None) -> ImportedRobot:
    """Return the robot of a file of bodies and one of cables, in any order; a missing one is searched beside.

    ``cable_set``: id of the set of cables; default: the file's own default. ``cable``: one of the table of cables.
    Raises `InputError` for what a robot file cannot describe, by name.
    """
    found = {}
    for path in _both(paths):
        root = read_xml(path, ROOTS)
        root = root.one(BODIES) if root.tag == "bodies_system" else root
        if root.tag in found:
            raise InputError(f"{path}: a second file of <{root.tag}>; one of <{BODIES}> and one of <{CABLES}> are read")
        found[root.tag] = path, root
    return _Reader(*found[BODIES], *found[CABLES], cable_set, cable).robot()


def _both(paths: Sequence[Path]) -> list[Path]:
    """Return two files; the one that is not given is that of the same name with the other ending."""
    if len(paths) == 2:
        return list(paths)
    if len(paths) != 1:
        raise InputError(f"{paths[0]}: {len(paths)} files; a CASPR model has two: bodies and cables")
    path = paths[0]
    for one, other in (("_bodies", "_cables"), ("_cables", "_bodies")):
        if path.stem.endswith(one):
            beside = path.with_name(path.stem.removesuffix(one) + other + path.suffix)
            if is_file(beside):
                return [path, beside]
            raise InputError(
                f"{path}: the second file of the CASPR model, {beside.name}, is not in the same folder; give both files"
            )
    raise InputError(f"{path}: this is one of the two files of a CASPR model; give both, bodies and cables")


@dataclass
class _Reader:
    """Two files, and what is noted while they are read."""

    bodies_path: Path
    bodies: Element
    cables_path: Path
    cables: Element
    cable_set: str | None
    cable: str | None
    normal: int | None = None  # axis across the plane of the joint

    def robot(self) -> ImportedRobot:
        """Return the robot of both CASPR files."""
        self.lost, self.assumed = Notes(), Notes()
        body = self._body()
        kind = self._joint(body)
        is_point = kind in (*_POINT, *_IN_A_PLANE)
        self.normal = _NORMALS[kind[-2:]] if kind in (*_PLANAR, *_IN_A_PLANE) else None
        physical = body.one("physical")
        centre = physical.one("com_location").numbers(3)
        place = self._joint_place(body)
        chosen = self._set()
        lines = [self._line(each, centre) for each in chosen.children]
        if not lines:
            raise InputError(f"{chosen.place}: <cable_set> is empty: a robot without lines")
        if is_point and not as_point(lines):
            raise InputError(f"{body.place}: a body that does not rotate but has several attachments is not supported")
        if not is_point and as_point(lines) and len(lines) > 1:
            self.lost.add("joint.type: all cables meet in one point, about which nothing holds a body: it is a point")
            is_point = True
        self._add_cables(lines)
        name = body.attribute("name") if "name" in body.attributes else ""
        exits = [line["exit_point"] for line in lines]
        table = {
            "schema": 1,
            "name": name_of(name, self.bodies_path),
            "scene": self._scene(body, exits, place),
            "platform": self._platform(physical, centre, is_point) | self._plane(place),
            "lines": lines,
        }
        self._note_unread(chosen, is_point)
        robot = validated(Robot, table, f"{self.bodies_path} with {self.cables_path.name}")
        return ImportedRobot(robot, "CASPR", self.lost.all, self.assumed.all)

    def _body(self) -> Element:
        links = self.bodies.children
        for link in links:
            if link.tag != "link_rigid":
                raise InputError(
                    f"{link.place}: <{link.tag[:60]}>: this link type is not supported; only link_rigid is"
                )
        if len(links) != 1:
            raise InputError(f"{self.bodies_path}: {len(links)} links; only robots with a single link are supported")
        return links[0]

    def _joint(self, body: Element) -> str:
        kind, known = body.one("joint").attribute("type"), (*_SPATIAL, *_POINT, *_PLANAR, *_IN_A_PLANE)
        if kind not in known:
            raise InputError(f"{body.place}: joint.type = {shown(kind)}: must be one of {', '.join(known)}")
        return kind

    def _joint_place(self, body: Element) -> Point:
        """Return where the joint is, m: the pose of a robot file is counted from the world's origin nonetheless."""
        parent = body.maybe("parent")
        if parent is None:
            return (0.0, 0.0, 0.0)
        if parent.one("num").numbers(1) != (0.0,):
            raise InputError(f"{parent.place}: <num> = {shown(parent.one('num').text)}: must be 0, the ground")
        place = parent.one("location").numbers(3)
        if any(each for k, each in enumerate(place) if k != self.normal):
            x, y, z = place
            self.lost.add(f"parent.location: poses count from the world's origin, not from {x:g}, {y:g}, {z:g} m")
        return place

    def _scene(self, body: Element, exits: list[Point], place: Point) -> dict[str, Any]:
        """Return the frame: the joint's limits about its *place* where they are a box, else that of the exit points."""
        scene = frame_of([*exits, place], self.cables_path, self.assumed, self.normal)
        joint, moving = body.one("joint"), [k for k in range(3) if k != self.normal]
        if not {"q_min", "q_max"} <= set(joint.attributes):
            return scene
        low, high = (joint.attribute(name).split() for name in ("q_min", "q_max"))
        if len(low) > len(moving):
            self.lost.add("joint.q_min, q_max of angles: a robot file has no such key")
        ends = [(number_or_none(a), number_or_none(b)) for a, b in zip(low, high, strict=False)][: len(moving)]
        if len(ends) < len(moving) or not all(a is not None and b is not None and a < b for a, b in ends):
            self.lost.add("joint.q_min, q_max: no box with a finite extent along each axis of the joint")
            return scene
        for name, column in zip(("frame_min", "frame_max"), zip(*ends, strict=True), strict=True):
            corner = list(scene[name])
            for k, value in zip(moving, column, strict=True):
                corner[k] = place[k] + value
            scene[name] = tuple(corner)
        self.assumed.drop(BOX)
        return scene

    def _plane(self, place: Point) -> dict[str, Any]:
        """Return the plane of a planar joint at a *place*, m, which holds both ways."""
        if self.normal is None:
            return {}
        across = tuple(float(k == self.normal) for k in range(3))
        return {"plane": {"normal": across, "distance": place[self.normal], "one_sided": False}}

    def _set(self) -> Element:
        sets = {each.attribute("id"): each for each in self.cables.all("cable_set")}
        if len(sets) < sum(1 for _ in self.cables.all("cable_set")):
            raise InputError(f"{self.cables_path}: two <cable_set> have the same id; give each an id of its own")
        if not sets:
            raise InputError(f"{self.cables_path}: <cables> has no <cable_set>")
        wanted = self.cable_set
        if wanted is None:
            default = "default_cable_set"
            wanted = self.cables.attribute(default) if default in self.cables.attributes else next(iter(sets))
        self.cables.skip("default_cable_set")
        if wanted not in sets:
            raise UnknownName("cable set", wanted, sets)
        return sets[wanted]

    def _line(self, cable: Element, centre: Point) -> dict[str, Any]:
        if cable.tag != "cable_ideal":
            raise InputError(
                f"{cable.place}: <{cable.tag[:60]}>: this cable type is not supported; only cable_ideal is"
            )
        reference = cable.attribute("attachment_reference") if "attachment_reference" in cable.attributes else "joint"
        if reference not in ("joint", "com"):
            raise InputError(f"{cable.place}: attachment_reference = {shown(reference)}: must be joint or com")
        ends = cable.one("attachments").children
        for end in ends:
            if end.tag != "attachment":
                raise InputError(
                    f"{end.place}: <{end.tag[:60]}>: this attachment type is not supported; only a point is"
                )
        if len(ends) != 2:
            raise InputError(f"{cable.place}: {len(ends)} attachments; only cables with two attachments are supported")
        places = {end.one("link").numbers(1)[0]: end.one("location").numbers(3) for end in ends}
        if set(places) != {0.0, 1.0}:
            raise InputError(f"{cable.place}: attachments must be one of link 0, the ground, and one of link 1")
        limits = cable.one("properties")
        low, high = (limits.one(key).numbers(1, least=0.0)[0] for key in ("force_min", "force_max"))
        from_joint = places[1.0] if reference == "joint" else _sum(places[1.0], centre)
        return {
            "name": cable.attribute("name"),
            "exit_point": places[0.0],
            "platform_point": from_joint,
            "sheave": {"kind": "eyelet"},
            "tension_limits": (low, high),
        }

    def _add_cables(self, lines: list[dict[str, Any]]) -> None:
        """Give each line a cable; the ideal ones of the file neither weigh nor stretch."""
        for line in lines:
            high = line["tension_limits"][1]
            line["cable"] = assumed_cable(high, self.assumed) if self.cable is None else chosen_cable(self.cable)
        if self.cable is not None:
            self.assumed.add(f"cable: {self.cable}, as requested")

    def _platform(self, physical: Element, centre: Point, is_point: bool) -> dict[str, Any]:
        mass = physical.one("mass").numbers(1, least=1e-9)[0]
        end = physical.maybe("end_location")
        nozzle = (0.0, 0.0, 0.0) if end is None else end.numbers(3)
        if is_point:
            if any(centre) or any(nozzle):
                self.lost.add("physical com_location, end_location: a point platform has none")
            return {"kind": "point", "mass": mass}
        table = {"kind": "rigid", "mass": mass, "centre_of_mass": centre, "nozzle": nozzle}
        tensor = physical.maybe("inertia")
        return table if tensor is None else table | self._inertia(tensor, mass, centre)

    def _inertia(self, tensor: Element, mass: float, centre: Point) -> dict[str, Any]:
        """Return the tensor about the centre of mass; of one about the joint by the parallel-axis theorem."""
        moments = [tensor.one(key).numbers(1)[0] for key in _MOMENTS]
        products = [tensor.one(key).numbers(1)[0] for key in _PRODUCTS]
        reference = tensor.attribute("ref") if "ref" in tensor.attributes else "com"
        if reference not in ("com", "joint"):
            raise InputError(f"{tensor.place}: ref = {shown(reference)}: must be com or joint")
        if reference == "joint":
            x, y, z = centre
            moments = [
                i - mass * d for i, d in zip(moments, (y * y + z * z, x * x + z * z, x * x + y * y), strict=True)
            ]
            products = [i + mass * d for i, d in zip(products, (x * y, x * z, y * z), strict=True)]
        table: dict[str, Any] = {"inertia": tuple(moments)}
        return table | ({"inertia_products": tuple(products)} if any(products) else {})

    def _note_unread(self, chosen: Element, is_point: bool) -> None:
        others = sum(1 for each in self.cables.all("cable_set")) - 1
        if others:
            self.lost.add(f"{others} other cable sets of the file: --cable-set ID reads another")
        for each in (*self.bodies.unread(), *chosen.unread("cables")):
            if each not in _NOT_OF_A_ROBOT and each != "cables.cable_set.id":
                of_a_body = is_point and ".physical.inertia" in each
                why = "a point platform has none" if of_a_body else "a robot file has no such key"
                self.lost.add(f"{each}: {why}")


def _sum(one: Point, other: Point) -> Point:
    return tuple(a + b for a, b in zip(one, other, strict=True))
