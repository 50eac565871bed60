"""Loads and writes robots: bundled names, URDFs and robot files."""

from importlib.resources import files
from pathlib import Path

import yaml

from orbident.errors import InputError
from orbident.files.names import suggestion
from orbident.files.schema_errors import validated
from orbident.files.text import read_text, write_text
from orbident.files.yaml_mapping import read_yaml_mapping
from orbident.orbits.ephemeris import Ephemeris
from orbident.robot.assembly import assembled
from orbident.robot.description import Robot
from orbident.robot.schema import RobotFile
from orbident.robot.urdf import read_urdf

_SCHEMA = "orbident/robot/1"
_YAML = {".yaml", ".yml"}


def bundled_robots() -> tuple[str, ...]:
    """The names of the robots that come with the package, sorted."""
    return tuple(sorted(path.stem for path in _library().glob("*.yaml")))


def load_robot(source: str | Path) -> Robot:
    """A robot, ready for every other function.

    What is odd but no error (inertias that no body can have, contradictions of
    `structure`, unbalanced wheels, mimicking joints) is in `Robot.warnings`.

    Args:
        source: a bundled name (see `bundled_robots`), a `.urdf` file, or a robot
            file (`.yaml`, `.yml`).

    Raises:
        InputError: the source or a file that it needs cannot be used. One line: file,
            place, what was found, what to do.
    """
    if str(source) in bundled_robots():
        return _from_robot_file(_library() / f"{source}.yaml", place=str(source))
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix == ".urdf":
        return _from_urdf(path)
    if suffix in _YAML:
        return _from_robot_file(path, place=str(path))
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
    document = {**robot.document, "name": robot.name, "urdf": "robot.urdf"}
    if robot.orbit is not None and isinstance(robot.orbit.motion, Ephemeris):
        document["orbit"] = {**document["orbit"], "oem": "robot.oem"}
        write_text(folder / "robot.oem", robot.orbit.motion.text)
    text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True)
    write_text(folder / "robot.urdf", robot.urdf)
    write_text(folder / "robot.yaml", text)
    return folder / "robot.yaml"


def _library() -> Path:
    return Path(str(files("orbident.robot") / "library"))


def _from_urdf(path: Path) -> Robot:
    text = read_text(path)
    urdf = read_urdf(text, str(path))
    document = {"schema": _SCHEMA, "name": urdf.name, "urdf": path.name}
    file = validated(RobotFile, document, str(path))
    return assembled(file, document, urdf, text, str(path))


def _from_robot_file(path: Path, place: str) -> Robot:
    document = read_yaml_mapping(read_text(path), place, _SCHEMA)
    file = validated(RobotFile, document, place)
    urdf_path = path.parent / file.urdf
    if not urdf_path.is_file():
        raise InputError(
            f"{place}: urdf: no file {urdf_path}; give a path relative to this file"
        )
    text = read_text(urdf_path)
    urdf = read_urdf(text, str(urdf_path))
    orbit = file.orbit.in_si(path.parent) if file.orbit else None
    return assembled(file, document, urdf, text, place, orbit)


def _not_a_robot(path: Path) -> str:
    kinds = "a bundled name, a .urdf or a .yaml robot file"
    # Somebody may pass a URDF's text, which is no path, and has many lines.
    if str(path).lstrip().startswith("<") or not str(path).isprintable():
        return f"found {str(path)[:40]!r}..., which is no path; give {kinds}"
    if path.is_dir():
        inside = path / "robot.yaml"
        hint = inside if inside.is_file() else kinds
        return f"{path}: is a folder; give {hint}"
    if path.suffix.lower() == ".xacro":
        return f"{path}: this is xacro; expand it first: xacro {path} > robot.urdf"
    if path.is_file():
        return f"{path}: this is no robot by its suffix; give {kinds}"
    known = suggestion(str(path), bundled_robots(), "robots")
    return (
        f"{path}: neither a file nor a bundled robot; {known}; "
        "or give a .urdf or .yaml file"
    )
