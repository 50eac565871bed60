"""SDFormat to links and joints.

The axis of a joint is in the joint's axes, or in those that `expressed_in` names;
before version 1.5 and with `use_parent_model_frame` in the model's.

A pose is relative to the frame that `relative_to` names. Where it names none, it is

- of a link, and of a frame that is attached to nothing: relative to the model's frame,
- of a frame: to the frame, link or joint that it is attached to,
- of a joint: to its child's frame,
- of the inertia: to the link's frame, always.
"""

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.files.bounds import LARGEST, SMALLEST
from orbident.files.names import quoted, refuse_unknown
from orbident.robot.urdf import UNLIMITED, Mimic, Urdf, UrdfJoint, UrdfLink, rotation_of
from orbident.robot.urdf_reader import numbers_in, parsed_xml, unique_names

MODEL = "__model__"
"""The name of the model's own frame."""

YES = ("true", "1")


class SdfPose(NamedTuple):
    """Where a frame is in another one."""

    R: Float[np.ndarray, "3 3"]
    p: Float[np.ndarray, "3"]

    def of(self, inner: "SdfPose") -> "SdfPose":
        """The pose in the outer frame of what has the pose `inner` in this one."""
        return SdfPose(self.R @ inner.R, self.p + self.R @ inner.p)

    def seen_from(self, other: "SdfPose") -> "SdfPose":
        """The pose in the frame `other`, which is given in the same outer frame."""
        return SdfPose(other.R.T @ self.R, other.R.T @ (self.p - other.p))


class Frames:
    """All frames of a model by name, and their poses."""

    def __init__(self, frames: dict[str, tuple[ET.Element, str]], place: str) -> None:
        """Keep links, joints and frames, each with the frame that its pose is in.

        That is where the pose names none; a joint or a frame moves with it too, while a
        link moves by itself. `place` is for messages.
        """
        self._frames, self._place = frames, place
        self._poses = {MODEL: SdfPose(np.eye(3), np.zeros(3))}

    def carrier(self, name: str, where: str) -> str:
        """What a frame is attached to in the end: a link, or a name that is none.

        Raises:
            InputError: it is attached to itself.
        """
        passed: list[str] = []
        while name in self._frames and self._frames[name][0].tag != "link":
            if name in passed:
                raise InputError(
                    f"{where}: {quoted(name)} is attached to itself; correct it"
                )
            passed.append(name)
            name = self._frames[name][1]
        return name

    def pose(self, name: str) -> SdfPose:
        """The pose of a link, joint or frame in the model's frame.

        Raises:
            InputError: it is relative to itself or to what is not there, or no numbers.
        """
        chain: list[str] = []
        while name not in self._poses:
            if name in chain:
                raise InputError(
                    f"{self._place}: the pose of {quoted(name)} is relative to "
                    "itself; correct its relative_to"
                )
            of = f"{quoted(chain[-1])} is" if chain else "an axis is"
            fault = f"{of} relative to {quoted(name)}, which is not in the file"
            refuse_unknown(name, self._frames, f"{self._place}: {fault}", "frames")
            chain.append(name)
            element, default = self._frames[name]
            pose = element.find("pose")
            name = (None if pose is None else pose.get("relative_to")) or default
        for each in reversed(chain):
            own = own_pose(self._frames[each][0], f"{self._place}: '{each}'")
            self._poses[each] = self._poses[name].of(own)
            name = each
        return self._poses[name]


def own_pose(element: ET.Element, where: str) -> SdfPose:
    """What the <pose> in an element says, relative to whatever it is relative to.

    Raises:
        InputError: it does not hold as many finite numbers as it should.
    """
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return SdfPose(np.eye(3), np.zeros(3))
    text, where = str(pose.text), f"{where}: <pose>"
    if pose.get("rotation_format") == "quat_xyzw":
        from scipy.spatial.transform import Rotation

        numbers = np.array(numbers_in(text, 7, where))
        if np.linalg.norm(numbers[3:]) < SMALLEST:
            raise InputError(f"{where}: the quaternion is zero; correct it")
        return SdfPose(Rotation.from_quat(numbers[3:]).as_matrix(), numbers[:3])
    numbers = np.array(numbers_in(text, 6, where))
    degrees = pose.get("degrees") in YES
    turned = np.radians(numbers[3:]) if degrees else numbers[3:]
    return SdfPose(rotation_of(turned), numbers[:3])


KINDS = ("revolute", "continuous", "prismatic", "fixed")
WORLD = "world"
FLAT = "give one flat model, as 'gz sdf -p FILE' writes it"
NEWEST, IN_JOINT_AXES = 12, 5
"""Versions are 1.0 to 1.12; from 1.5 on an axis is in the joint's axes."""

_PREFIX = re.compile(r"(?:</?|\s(?=[\w.-]+:[\w.-]+\s*=\s*['\"]))[\w.-]+:(?=\w)")
"""Gazebo does not ask that a prefix such as `gz:` is declared, as XML does."""


def read_sdf(text: str, place: str) -> Urdf:
    """The links and joints of the one model of an SDF file. No mesh is opened.

    Limits of which the lower one is above the other are left to `read_urdf`.

    Raises:
        InputError: malformed XML, no model or several, models in the model or by
            <include>, a version that is not known, a link without mass or inertia,
            names that are missing, unknown or
            given twice, frames that stand on each other, joints that are neither
            revolute, prismatic nor fixed, text where numbers belong.
    """
    root = parsed_xml(_PREFIX.sub(lambda found: found[0][:-1] + "_", text), place)
    version = _version(root, place)
    model = _model(root, place)
    name = model.get("name") or "robot"
    for tag in ("include", "model"):
        if model.find(tag) is not None:
            raise InputError(
                f"{place}: model '{name}' has another one in it (<{tag}>); " + FLAT
            )
    return _SdfReader(model, place, version < IN_JOINT_AXES).tree(name)


def _version(root: ET.Element, place: str) -> int:
    """The number after the dot: 1.10 comes after 1.9."""
    found = root.get("version")
    for number in range(NEWEST + 1):
        if found == f"1.{number}":
            return number
    said = "no version" if found is None else f"version {quoted(found)}"
    raise InputError(
        f"{place}: <sdf> has {said}; give the version of SDFormat in which the file is "
        f"written, from '1.0' to '1.{NEWEST}', as frames and axes depend on it"
    )


def _model(root: ET.Element, place: str) -> ET.Element:
    models = [*root.findall("model"), *root.findall("world/model")]
    if len(models) > 1:
        models = [
            model
            for model in models
            if (model.findtext("static") or "").strip() not in YES
        ]
    if len(models) == 1:
        return models[0]
    included = not models and root.find(".//include") is not None
    raise InputError(
        f"{place}: the model is included from another file; " + FLAT
        if included
        else f"{place}: found {len(models)} models that can move; give a file with one "
        "<model>"
    )


class _SdfReader:
    def __init__(self, model: ET.Element, place: str, in_model_axes: bool) -> None:
        self.place, self.in_model_axes = place, in_model_axes
        self.links = dict(self._named(model, "link"))
        self.joints = dict(self._named(model, "joint"))
        if not self.links:
            raise InputError(f"{place}: the model has no <link>; give at least a base")
        frames = {name: (link, MODEL) for name, link in self.links.items()}
        for name, joint in self.joints.items():
            child = self._text(joint, "child", f"{place}: joint '{name}'")
            frames[_joint_frame(name)] = joint, child
            # Old files may have a link of the same name.
            frames.setdefault(name, frames[_joint_frame(name)])
        for name, frame in self._named(model, "frame"):
            frames[name] = frame, frame.get("attached_to") or MODEL
        self.frames = Frames(frames, place)

    def _named(self, model: ET.Element, tag: str) -> list[tuple[str, ET.Element]]:
        elements = model.findall(tag)
        return list(zip(unique_names(elements, tag, self.place), elements, strict=True))

    def tree(self, name: str) -> Urdf:
        joints = [each for each in self.joints if not self._holds_base(each)]
        hung = {}
        for joint in joints:
            hung.setdefault(self._end(joint, "child"), joint)
        # A link's frame is at the joint that it hangs on; its axes stay.
        at = {link: self.frames.pose(link) for link in self.links}
        for link, joint in hung.items():
            at[link] = SdfPose(at[link].R, self.frames.pose(_joint_frame(joint)).p)
        return Urdf(
            name,
            tuple(self._link(link, at[link]) for link in self.links),
            tuple(self._joint(joint, at) for joint in joints),
            self.place,
        )

    def _holds_base(self, joint: str) -> bool:
        """Whether it fixes the base to the world, which then does not matter."""
        if self._end(joint, "parent") != WORLD:
            return False
        kind = self.joints[joint].get("type")
        if kind != "fixed":
            raise InputError(
                f"{self.place}: joint '{joint}' ({kind}) hangs the base on the world, "
                "but a base floats: remove the joint"
            )
        return True

    def _end(self, joint: str, end: str) -> str:
        """The link at this end of a joint, also where the file names a frame on it."""
        where = f"{self.place}: joint '{joint}'"
        name = self._text(self.joints[joint], end, where)
        name = self.frames.carrier(name, where)
        if name == WORLD and end == "parent":
            return WORLD
        fault = f"{where}: the {end} link {quoted(name)} is not in the file"
        refuse_unknown(name, self.links, fault, "links")
        return name

    def _text(self, element: ET.Element, tag: str, where: str) -> str:
        text = (element.findtext(tag) or "").strip()
        if not text:
            raise InputError(f"{where}: <{tag}> is missing; add it")
        return text

    def _number(
        self, element: ET.Element, tag: str, where: str, default: float = 0.0
    ) -> float:
        """The number in this child; the default without it."""
        text = element.findtext(tag)
        if text is None:
            return default
        bounded = element.tag != "limit"
        return numbers_in(text, 1, f"{where}: <{tag}>", bounded=bounded)[0]

    def _given(
        self, element: ET.Element, tag: str, otherwise: str, where: str
    ) -> float:
        """The number in a child for which SDF has a default that nobody means."""
        if element.find(tag) is None:
            raise InputError(
                f"{where}: <{tag}> is missing, for which SDF takes {otherwise}; give "
                "it, zero for a link that has none"
            )
        return self._number(element, tag, where)

    def _link(self, name: str, at: SdfPose) -> UrdfLink:
        where = f"{self.place}: link '{name}'"
        inertial = self.links[name].find("inertial")
        if inertial is not None and inertial.get("auto") in YES:
            raise InputError(
                f"{where}: <inertial auto='true'> is not read, which has its mass and "
                "inertia from shapes and their density; write both in numbers"
            )
        if inertial is None:
            raise InputError(
                f"{where}: <inertial> is missing, for which SDF takes 1 kg; give its "
                "mass and inertia, zeros for a link that has none"
            )
        mass = self._given(inertial, "mass", "1 kg", where)
        if mass < 0:
            raise InputError(f"{where}: found mass {mass:g} kg; give zero or more")
        com = self.frames.pose(name).of(own_pose(inertial, where)).seen_from(at)
        given = inertial.find("inertia")
        given = ET.Element("inertia") if given is None else given
        xx, yy, zz = (self._given(given, f"i{a}{a}", "1 kg m^2", where) for a in "xyz")
        xy, xz, yz = (self._number(given, f"i{ab}", where) for ab in ("xy", "xz", "yz"))
        I = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return UrdfLink(name, mass, com.p, com.R @ I @ com.R.T)

    def _joint(self, name: str, at: dict[str, SdfPose]) -> UrdfJoint:
        element, where = self.joints[name], f"{self.place}: joint '{name}'"
        kind = element.get("type")
        if kind not in KINDS:
            found = "no type" if kind is None else f"type {quoted(kind)}"
            raise InputError(f"{where}: found {found}; give one of {', '.join(KINDS)}")
        parent, child = self._end(name, "parent"), self._end(name, "child")
        placed = at[child].seen_from(at[parent])
        joint = UrdfJoint(name, kind, parent, child, placed.R, placed.p)
        if kind == "fixed":
            return joint
        given = element.find("axis")
        given = ET.Element("axis") if given is None else given
        axis = at[child].R.T @ self._axis(name, given, where)
        position, velocity = self._limits(given, kind, where)
        mimic = self._mimic(given, where)
        return replace(
            joint, axis=axis, position=position, velocity=velocity, mimic=mimic
        )

    def _mimic(self, axis: ET.Element, where: str) -> Mimic | None:
        """`q = multiplier (q' - reference) + offset`."""
        mimic = axis.find("mimic")
        if mimic is None:
            return None
        where = f"{where}: <mimic>"
        self._text(mimic, "multiplier", where)
        multiplier, offset, reference = (
            self._number(mimic, tag, where)
            for tag in ("multiplier", "offset", "reference")
        )
        leader = mimic.get("joint", "")
        return Mimic(leader, multiplier, offset - multiplier * reference)

    def _axis(self, joint: str, axis: ET.Element, where: str) -> Float[np.ndarray, "3"]:
        """The unit vector in the model's axes."""
        xyz = axis.find("xyz")
        text = "0 0 1" if xyz is None else str(xyz.text)
        vector = np.array(numbers_in(text, 3, f"{where}: <xyz>"))
        norm = float(np.linalg.norm(vector))
        if norm < SMALLEST:
            raise InputError(f"{where}: found axis 0 0 0; give a nonzero vector")
        said = None if xyz is None else xyz.get("expressed_in")
        old = (axis.findtext("use_parent_model_frame") or "").strip() in YES
        frame = said or (MODEL if old or self.in_model_axes else _joint_frame(joint))
        return self.frames.pose(frame).R @ vector / norm

    def _limits(
        self, axis: ET.Element, kind: str, where: str
    ) -> tuple[tuple[float, float] | None, float | None]:
        limit = axis.find("limit")
        if limit is None:
            return None, None
        lower = self._number(limit, "lower", where, -math.inf)
        upper = self._number(limit, "upper", where, math.inf)
        velocity = self._number(limit, "velocity", where, -1.0)
        free = kind == "continuous" or lower == upper or min(-lower, upper) > LARGEST
        ends = max(lower, -UNLIMITED), min(upper, UNLIMITED)
        moves = 0 < velocity <= LARGEST
        return None if free else ends, velocity if moves else None


def _joint_frame(joint: str) -> str:
    """A name for the joint's own frame that no element can have."""
    return f"{joint}\n"
