"""Loads and writes robots: bundled names, models of other tools and robot files."""

from importlib.resources import files
from pathlib import Path

import yaml

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.files.pipes import refuse_pipe
from orbident.files.schema_errors import validated
from orbident.files.text import read_text, write_text
from orbident.files.yaml_mapping import read_yaml_mapping
from orbident.orbits.ephemeris import Ephemeris
from orbident.robot.assembly import assembled
from orbident.robot.description import Robot
from orbident.robot.formats.model_file import KINDS, SUFFIXES, as_urdf, read_model
from orbident.robot.formats.plain_tree import tree_of_bodies, tree_of_table
from orbident.robot.schema import BODIES, RobotFile
from orbident.robot.urdf import Urdf

_SCHEMA = "orbident/robot/1"
_YAML = {".yaml", ".yml"}


def bundled_robots() -> tuple[str, ...]:
    """The names of the robots that come with the package, sorted."""
    return tuple(sorted(path.stem for path in _library().glob("*.yaml")))


def load_robot(source: str | Path) -> Robot:
    """A robot, ready for every other function.

    What is odd but no error (inertias that no body can have, contradictions of
    `structure`, unbalanced wheels) is in `Robot.warnings`.

    Args:
        source: a bundled name (see `bundled_robots`), a robot file (`.yaml`, `.yml`),
            or a URDF, xacro, MJCF or SDF file.

    Raises:
        InputError: the source or a file that it needs cannot be used. One line: file,
            place, what was found, what to do.
        MissingLibraryError: the extra that this kind of file needs is not installed.
    """
    if str(source) in bundled_robots():
        return _from_robot_file(_library() / f"{source}.yaml", place=str(source))
    path = Path(source)
    refuse_pipe(path, "the robot")
    suffix = path.suffix.lower()
    if suffix in _YAML:
        return _from_robot_file(path, place=str(path))
    if suffix in SUFFIXES:
        return _from_model(path)
    raise InputError(_not_a_robot(path))


def write_robot(robot: Robot, folder: str | Path) -> Path:
    """Writes `robot.yaml` and `robot.urdf`, from which the same robot loads again.

    An OEM of its orbit is written beside them, as `robot.oem`.

    Args:
        robot: one that was loaded; what is written is its document and URDF.
        folder: made if it is missing; files of these names are replaced.

    Returns:
        The path of `robot.yaml`.

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
    named = [document.get(key) for key in BODIES if key in document]
    if named != ["robot.urdf"]:
        raise InputError(
            f"{path}: names another file than robot.urdf, which Orbident writes; give "
            "a folder as it was written"
        )
    return load_robot(path)


def _library() -> Path:
    return Path(str(files("orbident.robot") / "library"))


def _from_model(path: Path) -> Robot:
    urdf, text = read_model(path)
    document = {"schema": _SCHEMA, "name": urdf.name, "urdf": path.name}
    file = validated(RobotFile, document, str(path))
    return assembled(file, document, urdf, text, str(path))


def _from_robot_file(path: Path, place: str) -> Robot:
    document = read_yaml_mapping(read_text(path), place, _SCHEMA)
    file = validated(RobotFile, document, place)
    orbit = file.orbit.in_si(path.parent) if file.orbit else None
    return assembled(file, document, *_bodies(file, path, place), place, orbit)


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
        hint = inside if inside.is_file() else kinds
        return f"{path}: is a folder; give {hint}"
    if path.is_file():
        known = ", ".join((*sorted(_YAML), *SUFFIXES))
        return f"{path}: unknown type of file; known ones: {known}"
    known = suggestion(str(path), bundled_robots(), "robots")
    return (
        f"{path}: neither a file nor a bundled robot; {known}; "
        f"or give a .yaml robot file, or {KINDS}"
    )
