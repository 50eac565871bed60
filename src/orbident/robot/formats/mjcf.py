"""MJCF to links and joints, as MuJoCo itself compiles it."""

import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import chdir
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from jaxtyping import Float

from orbident.errors import InputError
from orbident.extras import extra, require_library
from orbident.files.confined import ConfinedError, confined
from orbident.files.names import listed, one_line
from orbident.robot.urdf import Mimic, Urdf, UrdfJoint, UrdfLink, urdf_text

_Vector = Float[np.ndarray, "3"]

_FREE, _BALL, _SLIDE = 0, 1, 2
"""Of `mjtJoint`."""


_NAN = re.compile(r"""=\s*(["'])(?:[\s\d.eE+-]|\binf\b)*\bnan\b""", re.IGNORECASE)
"""Among numbers. MuJoCo prints a warning of it past Python, and goes on."""

_SECONDS, _MEGABYTES = 3, 800
"""Bodies, joints and inertias take milliseconds, and a mesh of 80 000 triangles that
weighs 0.2 s and 100 MB."""


def mjcf_as_urdf(text: str, path: Path) -> str:
    """The URDF that says the same as a MuJoCo model.

    MuJoCo compiles it in a child process: a small file may ask for hours and gigabytes,
    and MuJoCo crashes where a file attaches itself. It reads the file once more, with
    all that it includes.

    Raises:
        InputError: as `compiled_mjcf`, and where MuJoCo takes too much or crashes.
        MissingLibraryError: the extra `mujoco` is not installed.
    """
    with extra("mujoco", f"{path}: an MJCF file"):
        require_library("mujoco")
    if _NAN.search(text):
        raise InputError(f"{path}: found 'NaN' among numbers; give finite numbers")
    try:
        return confined(
            compiled_mjcf, str(path), seconds=_SECONDS, megabytes=_MEGABYTES
        )
    except ConfinedError as error:
        raise InputError(
            f"{path}: MuJoCo {error} with this file; take out what repeats or contains "
            "itself, and give the bodies that large meshes weigh an <inertial>"
        ) from None


def compiled_mjcf(place: str) -> str:
    """What `mjcf_as_urdf` gives, in this process.

    The base is the one body of the world that has a free joint, or two slides and a
    hinge (a table), or none. A body with several joints becomes as many links, all but
    the last without mass. Link frames are at the joints, where MuJoCo's are anywhere.

    Raises:
        InputError: MuJoCo refuses the model; it has no body, several that may be the
            base, a base that is held, ball joints, or loops.
    """
    # MuJoCo's windows, which take a third of its import, are of no use.
    os.environ["MUJOCO_GL"] = "disable"
    import mujoco

    # Its stubs do not say what it exports.
    api: Any = mujoco
    try:
        # MuJoCo warns of what troubles a simulation; inertias are judged elsewhere.
        # It also writes them into a file of the working directory.
        path = str(Path(place).absolute())
        with (
            warnings.catch_warnings(action="ignore"),
            TemporaryDirectory() as elsewhere,
            chdir(elsewhere),
        ):
            spec = api.MjSpec.from_file(path)
            ties = [_Tie(each) for each in spec.equalities if each.active]
            gears = _gears(api, spec)
            _leave_inertias_alone(spec)
            model = spec.compile()
    # What MuJoCo raises for a file has many types.
    except Exception as error:
        said = one_line(error)
        # The latter is what its bindings make of C++'s `bad_alloc`.
        if isinstance(error, MemoryError) or "unknown exception" in said:
            raise MemoryError from None
        cure = "correct the file"
        if "opening file" in said:
            cure = "put it there, or give the bodies that it weighs an <inertial>"
        raise InputError(f"{place}: MuJoCo cannot read it: {said}; {cure}") from None
    reader = _MjcfReader(model, api.mju_quat2Mat, place, gears)
    # MuJoCo has a name for a model without one.
    named = spec.modelname != api.MjSpec().modelname
    tree = reader.tree(spec.modelname if named else Path(place).stem)
    return urdf_text(replace(tree, joints=reader.coupled(tree.joints, ties)))


def _leave_inertias_alone(spec: Any) -> None:
    """Take out of a model what has no part in inertias, as meshes that are missing."""
    for kind in ("keys", "sensors", "actuators", "tendons", "equalities", "pairs"):
        _delete(spec, getattr(spec, kind))
    _delete(spec, [*spec.excludes, *spec.skins, *spec.tuples])
    inferred = int(spec.compiler.inertiafromgeom) == 1
    for body in spec.bodies:
        weighs = body.name != "world" and (inferred or not body.explicitinertial)
        _delete(spec, [] if weighs else body.geoms)
    for geom in spec.geoms:
        geom.material = ""
    used = {geom.meshname for geom in spec.geoms}
    _delete(spec, [mesh for mesh in spec.meshes if mesh.name not in used])
    _delete(spec, [*spec.materials, *spec.textures, *spec.hfields])
    # The memory that a simulation is to have.
    spec.nkey = spec.nuserdata = 0


def _gears(api: Any, spec: Any) -> dict[str, float]:
    """The gear of each joint that one actuator drives; 1 is what nobody has said."""
    driven = [
        (each.target, float(each.gear[0]))
        for each in spec.actuators
        if each.trntype == api.mjtTrn.mjTRN_JOINT
    ]
    targets = [target for target, _ in driven]
    return {
        target: gear
        for target, gear in driven
        if gear not in (0.0, 1.0) and targets.count(target) == 1
    }


def _delete(spec: Any, elements: Any) -> None:
    for element in list(elements):
        spec.delete(element)


class _Tie:
    """An equality of the file; it goes before the model is compiled."""

    def __init__(self, equality: Any) -> None:
        # mjEQ_JOINT and so on, after the names of the elements.
        self.kind = equality.type.name.removeprefix("mjEQ_").lower()
        self.of_sites = equality.objtype.name == "mjOBJ_SITE"
        self.names = [name for name in (equality.name1, equality.name2) if name]
        self.polycoef = [float(x) for x in equality.data[:5]]


class _MjcfReader:
    """A compiled model's bodies, by the numbers that MuJoCo gives them."""

    def __init__(
        self, model: Any, quat2mat: Any, place: str, gears: Mapping[str, float]
    ) -> None:
        self.model, self.quat2mat, self.place = model, quat2mat, place
        self.gears = gears
        self.joints = [
            range(first, first + count)
            for first, count in zip(model.body_jntadr, model.body_jntnum, strict=True)
        ]
        self.bodies = [model.body(i).name or f"body{i}" for i in range(model.nbody)]
        self.anchors: dict[int, _Vector] = {}
        """Origin of each link's frame in MuJoCo's frame of its body, m."""

    def tree(self, name: str) -> Urdf:
        base = self._base()
        links, joints = [self._link(base, np.zeros(3))], []
        if _SLIDE in self._kinds(base):
            # No body can have the name of the world.
            links.append(UrdfLink("world"))
            joints.append(self._table(base))
        for body in range(base + 1, self.model.nbody):
            if int(self.model.body_parentid[body]) in self.anchors:
                for link, joint in self._hung(body):
                    links.append(link)
                    joints.append(joint)
        return Urdf(name, tuple(links), tuple(joints), self.place)

    def coupled(
        self, joints: Iterable[UrdfJoint], ties: Iterable[_Tie]
    ) -> tuple[UrdfJoint, ...]:
        """The joints, those that an equality makes followers with what they mimic.

        Raises:
            InputError: an equality is another than a straight line between two joints.
        """
        mimics: dict[str, Mimic] = {}
        for tie in ties:
            if not any(self._is_of_robot(tie, name) for name in tie.names):
                continue
            a_0, a_1, *curved = tie.polycoef
            if tie.kind != "joint" or len(tie.names) < 2 or any(curved):
                raise InputError(
                    f"{self.place}: <equality> <{tie.kind}> of {listed(tie.names)} "
                    "closes a loop or holds the robot; only a joint that follows "
                    "another by polycoef='a0 a1 0 0 0' is possible: take it out"
                )
            follower, leader = tie.names
            # q - ref = a_0 + a_1 (q' - ref') of the follower's q, the leader's q'.
            offset = self._ref(follower) + a_0 - a_1 * self._ref(leader)
            mimics[follower] = Mimic(leader, a_1, offset)
        return tuple(replace(each, mimic=mimics.get(each.name)) for each in joints)

    def _is_of_robot(self, tie: _Tie, name: str) -> bool:
        """False of scenery; true of all whose place is not known."""
        model = self.model
        try:
            if tie.kind == "joint":
                body = model.jnt_bodyid[model.joint(name).id]
            elif tie.kind not in {"connect", "weld"}:
                return True
            elif tie.of_sites:
                body = model.site(name).bodyid[0]
            else:
                body = model.body(name).id
        except KeyError:
            raise InputError(
                f"{self.place}: <equality> <{tie.kind}> names {name!r}, which the "
                "model does not have; correct the name"
            ) from None
        return int(body) in self.anchors

    def _ref(self, joint: str) -> float:
        return float(self.model.qpos0[self.model.joint(joint).qposadr[0]])

    def _base(self) -> int:
        top = [b for b in range(1, self.model.nbody) if not self.model.body_parentid[b]]
        if not top:
            raise InputError(f"{self.place}: <mujoco> has no <body>; give a base")
        bases = [b for b in top if self._kinds(b)[:1] == [_FREE]] or top
        if len(bases) > 1:
            names = listed(self.bodies[b] for b in bases)
            raise InputError(
                f"{self.place}: the bodies {names} are all at the top of the world, "
                "and each may be the base (several roots); give one of them alone a "
                "<freejoint/>"
            )
        base = bases[0]
        kinds = sorted(self._kinds(base))
        if kinds not in ([], [_FREE], [_SLIDE, _SLIDE, _SLIDE + 1]):
            raise InputError(
                f"{self.place}: body '{self.bodies[base]}' hangs on the world by "
                f"{'a joint' if len(kinds) == 1 else f'{len(kinds)} joints'}, but a "
                "base floats: give it a <freejoint/>, or two slides and a hinge if it "
                "is on a table"
            )
        return base

    def _table(self, base: int) -> UrdfJoint:
        """What two slides and a hinge are to a URDF; its axis is the hinge's."""
        hinge = self.joints[base][self._kinds(base).index(_SLIDE + 1)]
        name, axis = self.bodies[base], self.model.jnt_axis[hinge].copy()
        return UrdfJoint(
            f"{name}_table", "planar", "world", name, np.eye(3), np.zeros(3), axis
        )

    def _kinds(self, body: int) -> list[int]:
        return [int(self.model.jnt_type[j]) for j in self.joints[body]]

    def _hung(self, body: int) -> Iterator[tuple[UrdfLink, UrdfJoint]]:
        """A body's links, one a joint, each with the joint that it hangs on."""
        model, parent = self.model, int(self.model.body_parentid[body])
        above, R = self.bodies[parent], self._matrix(model.body_quat[body])
        p = model.body_pos[body] - self.anchors[parent]
        for j in self.joints[body]:
            last = j == self.joints[body][-1]
            anchor = model.jnt_pos[j].copy()
            R_q, p_q = self._at_zero(j)
            name = self.bodies[body] if last else f"{self._name(j)}_link"
            link = self._link(body, anchor) if last else UrdfLink(name)
            yield link, self._joint(j, above, name, R @ R_q, p + R @ (anchor + p_q))
            # The next joint of this body stands in the frame of this one.
            above, R, p = name, np.eye(3), -anchor
        if not len(self.joints[body]):
            name = self.bodies[body]
            joint = UrdfJoint(f"{name}_fixed", "fixed", above, name, R, p)
            yield self._link(body, np.zeros(3)), joint

    def _name(self, j: int) -> str:
        return self.model.joint(j).name or f"joint{j}"

    def _at_zero(
        self, j: int
    ) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3"]]:
        """The motion from the body as drawn, at `ref`, to where the joint is zero."""
        ref, axis = self.model.qpos0[self.model.jnt_qposadr[j]], self.model.jnt_axis[j]
        if self.model.jnt_type[j] == _SLIDE:
            return np.eye(3), -ref * axis
        quat = np.array([np.cos(-ref / 2), *(np.sin(-ref / 2) * axis)])
        return self._matrix(quat), np.zeros(3)

    def _joint(
        self,
        j: int,
        parent: str,
        child: str,
        R: Float[np.ndarray, "3 3"],
        p: Float[np.ndarray, "3"],
    ) -> UrdfJoint:
        kind, name = self.model.jnt_type[j], self._name(j)
        if kind == _BALL:
            raise InputError(
                f"{self.place}: joint '{name}' is a ball joint; write it as three "
                "hinges of the same body"
            )
        lower, upper = map(float, self.model.jnt_range[j])
        return UrdfJoint(
            name,
            "prismatic" if kind == _SLIDE else "revolute",
            parent,
            child,
            R,
            p,
            axis=self.model.jnt_axis[j].copy(),
            position=(lower, upper) if self.model.jnt_limited[j] else None,
            gear=self.gears.get(name),
            armature=float(self.model.dof_armature[self.model.jnt_dofadr[j]]),
        )

    def _link(self, body: int, anchor: Float[np.ndarray, "3"]) -> UrdfLink:
        model = self.model
        self.anchors[body] = anchor
        R = self._matrix(model.body_iquat[body])
        return UrdfLink(
            self.bodies[body],
            float(model.body_mass[body]),
            model.body_ipos[body] - anchor,
            R @ np.diag(model.body_inertia[body]) @ R.T,
        )

    def _matrix(self, quat: Float[np.ndarray, "4"]) -> Float[np.ndarray, "3 3"]:
        """The rotation of MuJoCo's quaternion, which has its scalar first."""
        R = np.zeros(9)
        self.quat2mat(R, quat)
        return R.reshape(3, 3)
