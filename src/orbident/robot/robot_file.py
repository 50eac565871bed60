"""Loads and writes robots: bundled names, models of other tools and robot files."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from orbident.errors import InputError
from orbident.files.names import refuse_unknown, suggestion
from orbident.files.replacing import write_text
from orbident.files.schema_parts import read_yaml_mapping, validated
from orbident.files.text import read_text, refuse_pipe
from orbident.orbits.orbit import Ephemeris, Orbit
from orbident.robot.body_schema import tree_of_bodies, tree_of_table
from orbident.robot.description import DAMPING_STD, NO_FRICTION, NO_ROTOR, Robot, Wheel
from orbident.robot.formats.model_file import KINDS, SUFFIXES, as_urdf, read_model
from orbident.robot.fusing import Bodies, LinkTree, fused, link_tree, wheel_on_joint
from orbident.robot.joint_schema import (
    armature_stds,
    check_driven,
    check_passive,
    check_rotors,
    couplings_of,
    proposed_rotors,
    with_flexible_joints,
)
from orbident.robot.oddities import contradictions, nonphysical
from orbident.robot.schema import BODIES, RobotFile
from orbident.robot.tolerances import EVERY
from orbident.robot.urdf import Urdf
from orbident.robot.urdf_reader import read_urdf


def assembled(
    file: RobotFile,
    document: dict[str, Any],
    urdf: Urdf,
    text: str,
    place: str,
    orbit: Orbit | None = None,
) -> Robot:
    """The robot that a robot file and its URDF describe.

    The document is the robot file as it was read, and the text is the URDF's.

    Raises:
        InputError: the file names joints or bodies that the URDF does not have, a
            joint that cannot be a wheel, or nothing has mass.
    """
    tree = link_tree(urdf, file.base_link)
    if file.base is not None:
        own = file.base.as_link(tree.base)
        tree = replace(tree, links={**tree.links, tree.base: own})
    wheels, wheel_warnings = _wheels(file, tree, place)
    held = frozenset(w.joint for w in file.wheels if w.joint is not None)
    bodies = fused(tree, held=held, feature_point=file.feature_point)
    if not bodies.theta[:, 0].sum() > 0:
        raise InputError(
            f"{urdf.place}: no link has mass; give nominal values in <inertial>"
        )
    links = (tree.links[name] for name in bodies.placements)
    faults = [nonphysical(each.name, each.mass, each.I_file) for each in links]
    names = [joint.name for joint in bodies.joints]
    # That no motor has a gear may be said without names.
    none = file.rotors == {EVERY: NO_ROTOR}
    rotors = dict.fromkeys(names, NO_ROTOR) if none else file.rotors
    _check_names(file, rotors, bodies, place)
    couplings, uncoupled = couplings_of(urdf, names)
    check_passive(file.passive, couplings, place)
    check_rotors(rotors, bodies.joints, bodies.names, file.structure, place)
    driven = {
        "friction": file.friction,
        "torque_constants": file.torque_constants,
        "rotors": [name for name, rotor in rotors.items() if rotor != NO_ROTOR],
    }
    check_driven(driven, file.passive, place)
    friction = {name: file.friction.get(name, NO_FRICTION) for name in names}
    return Robot(
        name=file.name or urdf.name,
        motion=file.motion,
        bodies=bodies.names,
        joints=tuple(
            replace(joint, **file.limits[joint.name].model_dump(exclude_none=True))
            if joint.name in file.limits
            else joint
            for joint in bodies.joints
        ),
        theta=bodies.theta,
        feature_point=np.array(file.feature_point),
        couplings=couplings,
        wheels=wheels,
        rotors=rotors,
        torque_constants=file.torque_constants,
        friction=file.friction,
        thrusters=file.thrusters,
        torquers=file.torquers,
        pads={name: bodies.placements[name].p + at for name, at in file.pads.items()},
        disturbances=file.disturbances,
        momentum_walk=file.momentum_walk,
        passive=file.passive,
        at_rest=file.at_rest,
        orbit=orbit,
        known=file.known,
        structure=file.structure,
        sensors=file.sensors,
        tolerances=replace(
            file.tolerances.in_si(
                bodies.joints, file.thrusters, file.torque_constants, place
            ),
            joint_frequency={n: each.tolerance for n, each in file.passive.items()},
            joint_damping=dict.fromkeys(file.passive, DAMPING_STD),
            joint_armature=armature_stds(rotors, bodies.joints),
            joint_viscous={n: x.std(x.viscous) for n, x in friction.items()},
            joint_coulomb={n: x.std(x.coulomb) for n, x in friction.items()},
            joint_torque_offset={n: x.std(x.offset) for n, x in friction.items()},
        ),
        warnings=(
            *urdf.warnings,
            *_on_a_table(urdf, file),
            *chain.from_iterable(faults),
            *wheel_warnings,
            *uncoupled,
            *proposed_rotors(urdf, bodies.joints, rotors),
            *contradictions(bodies.names, bodies.theta, file.structure),
        ),
        document=document,
        urdf=text,
    )


def _on_a_table(urdf: Urdf, file: RobotFile) -> Iterator[str]:
    # Elsewhere than above the base such a joint was refused.
    planar = [joint.name for joint in urdf.joints if joint.kind == "planar"]
    if planar and file.motion != "planar":
        yield (
            f"joint '{planar[0]}' above the base is planar: if the robot floats on a "
            "table, give motion: planar in a robot file"
        )


def _wheels(
    file: RobotFile, tree: LinkTree, place: str
) -> tuple[tuple[Wheel, ...], list[str]]:
    wheels, warnings = [], []
    joints = [entry.joint for entry in file.wheels if entry.joint is not None]
    for i, entry in enumerate(file.wheels):
        where = f"{place}: wheels[{i}]"
        if entry.joint is None:
            # The schema has checked that both are there.
            axis, inertia = np.array(entry.axis), entry.inertia or 0.0
            axis /= np.linalg.norm(axis)
        elif joints.count(entry.joint) > 1:
            raise InputError(
                f"{where}: joint '{entry.joint}' is a wheel twice; keep one"
            )
        else:
            found = wheel_on_joint(tree, entry.joint, where, entry.inertia)
            axis, inertia, faults = found
            warnings += faults
        wheels.append(Wheel(entry.label, axis, inertia, entry.mode))
    return tuple(wheels), warnings


def _check_names(
    file: RobotFile, rotors: Collection[str], bodies: Bodies, place: str
) -> None:
    """Refuse what a section says of a body or a joint that the robot does not have."""
    of_bodies = {
        "structure": file.structure,
        "pads": file.pads,
        "known: bodies": file.known.bodies,
    }
    of_joints = {
        "passive": file.passive,
        "rotors": rotors,
        "friction": file.friction,
        "torque_constants": file.torque_constants,
        "limits": file.limits,
    }
    for sections, known, one, several in (
        (of_bodies, bodies.names, "body", "bodies"),
        (of_joints, [joint.name for joint in bodies.joints], "joint", "joints"),
    ):
        for section, named in sections.items():
            for name in named:
                fault = f"{place}: {section}: no {one} {name!r}"
                refuse_unknown(name, known, fault, several)


_SCHEMA = "orbident/robot/1"
_YAML = {".yaml", ".yml"}


def bundled_robots() -> tuple[str, ...]:
    """The names of the robots that come with the package, sorted."""
    return tuple(sorted(path.stem for path in _library().glob("*.yaml")))


def load_robot(source: str | Path | Mapping[str, Any]) -> Robot:
    """A robot, ready for every other function.

    What is odd but no error (inertias that no body can have, contradictions of
    `structure`, unbalanced wheels) is in `Robot.warnings`.

    Args:
        source: a bundled name (see `bundled_robots`), a robot file (`.yaml`, `.yml`),
            a URDF, xacro, MJCF or SDF file, or what a robot file has, by its keys:
            files that it names are then relative to the working directory.

    Raises:
        InputError: the source or a file that it needs cannot be used. One line: file,
            place, what was found, what to do.
        MissingLibraryError: the extra that this kind of file needs is not installed.
    """
    if isinstance(source, Mapping):
        path, place, text = Path("robot.yaml"), "robot", ""
        document = {"schema": _SCHEMA, **_plain(source)}
    else:
        path, place = Path(source), str(source)
        if place in bundled_robots():
            path = _library() / f"{place}.yaml"
        refuse_pipe(path, "the robot")
        suffix = path.suffix.lower()
        if suffix in SUFFIXES:
            urdf, text = read_model(path)
            document = {"schema": _SCHEMA, "name": urdf.name, "urdf": path.name}
            file = validated(RobotFile, document, str(path))
            return assembled(file, document, urdf, text, str(path))
        if suffix not in _YAML:
            raise InputError(_not_a_robot(path))
        text = read_text(path)
        document = read_yaml_mapping(text, place, _SCHEMA)
    return _described(document, path, place, text)


def _plain(value: Any) -> Any:
    """As YAML would have it: arrays are lists, and their numbers are Python's."""
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def write_robot(robot: Robot, folder: str | Path) -> Path:
    """Writes `robot.yaml` and `robot.urdf`, from which the same robot loads again.

    An OEM of its orbit is written beside them, as `robot.oem`. What is written is its
    document and URDF. The folder is made if it is missing, and files of these names are
    replaced. Gives the path of `robot.yaml`.

    Raises:
        InputError: the robot has no document or URDF, or the folder is a file.
    """
    if not robot.document or not robot.urdf:
        raise InputError(
            f"robot '{robot.name}' was not loaded from a file; nothing can be written"
        )
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError(f"{folder}: is a file; give a folder") from None
    kept = {key: value for key, value in robot.document.items() if key not in BODIES}
    document = {**kept, "name": robot.name, "urdf": "robot.urdf"}
    if robot.orbit is not None and isinstance(robot.orbit.motion, Ephemeris):
        document["orbit"] = {**document["orbit"], "oem": "robot.oem"}
        write_text(folder / "robot.oem", robot.orbit.motion.text)
    text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True)
    write_text(folder / "robot.urdf", robot.urdf)
    write_text(folder / "robot.yaml", text)
    return folder / "robot.yaml"


def load_written_robot(folder: Path) -> Robot:
    """The robot that `write_robot` wrote.

    A folder that somebody sent may name any file as the robot's, and a xacro file is a
    program: only `robot.urdf` in the folder itself is read.

    Raises:
        InputError: as `load_robot`, and where `robot.yaml` names another file.
    """
    path = folder / "robot.yaml"
    document = read_yaml_mapping(read_text(path), str(path), _SCHEMA)
    if [document.get(key) for key in BODIES if key in document] != ["robot.urdf"]:
        raise InputError(
            f"{path}: names another file than robot.urdf, which Orbident writes; give "
            "a folder as it was written"
        )
    return load_robot(path)


def _library() -> Path:
    return Path(str(files("orbident.robot") / "library"))


def _described(document: dict[Any, Any], path: Path, place: str, read: str) -> Robot:
    """The robot of a document; files that it names are relative to its path."""
    file = validated(RobotFile, document, place, read)
    orbit = file.orbit.in_si(path.parent) if file.orbit else None
    urdf, text = _bodies(file, path, place)
    if file.flexible:
        document, text = with_flexible_joints(document, text, place)
        file, urdf = validated(RobotFile, document, place), read_urdf(text, urdf.place)
    return assembled(file, document, urdf, text, place, orbit)


def _bodies(file: RobotFile, path: Path, place: str) -> tuple[Urdf, str]:
    """Links and joints, whichever key has them, and their URDF."""
    name = file.name or path.stem
    if file.bodies is not None:
        return as_urdf(tree_of_bodies(file.bodies, name, place))
    if file.dh is not None:
        return as_urdf(tree_of_table(file.dh, name, place))
    model = path.parent / file.model_file
    if not model.is_file():
        key = "model" if file.model else "urdf"
        raise InputError(
            f"{place}: {key}: no file {model}; give a path relative to this file"
        )
    return read_model(model)


def _not_a_robot(path: Path) -> str:
    kinds = f"a bundled name, a .yaml robot file, or {KINDS}"
    # Somebody may pass a file's text, which is no path, and has many lines.
    if str(path).lstrip().startswith("<") or not str(path).isprintable():
        return f"found {str(path)[:40]!r}..., which is no path; give {kinds}"
    if path.is_dir():
        inside = path / "robot.yaml"
        return f"{path}: is a folder; give {inside if inside.is_file() else kinds}"
    if path.is_file():
        known = ", ".join((*sorted(_YAML), *SUFFIXES))
        return f"{path}: unknown type of file; known ones: {known}"
    known = suggestion(str(path), bundled_robots(), "robots")
    return (
        f"{path}: neither a file nor a bundled robot; {known}; "
        f"or give a .yaml robot file, or {KINDS}"
    )
