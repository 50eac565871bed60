"""The recursive filter of one robot as a folder of C and C++, with golden vectors.

The folder holds the code that Python runs, and the robot as a constant table in C,
`robot.h`. A flight computer gets the samples as the filter takes them.
"""

import re
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from shutil import copyfile
from string import Template
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.errors import InputError
from orbident.estimation.linear_fits import known_momentum
from orbident.estimation.recursive.driven_joints import Torques, torques_of
from orbident.estimation.recursive.filter import (
    UNCERTAINTY,
    Extended,
    cad_covariance,
    cad_prior,
    factor_of,
)
from orbident.estimation.recursive.filter_input import filter_input_of
from orbident.estimation.recursive.history import Detector, filter_history
from orbident.estimation.result import Result
from orbident.files.replacing import replacing_files
from orbident.identified.generated_code import template_text
from orbident.model.equations_of_motion import check_regular
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.preprocessing.delays import base_clocks, corrections
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import screened
from orbident.recordings.recording import Recording
from orbident.robot.description import Joint, Robot, Wheel
from orbident.robot.joint_schema import require_measured

SPARSE = (
    "theta_of_linear",
    "theta_of_sigma",
    "theta_of_beta",
    "pi_of_shown",
    "pi_of_products",
)
PER_LINE = 6
"""Numbers."""

Floats = Sequence[float] | np.ndarray


def robot_header(robot: Robot, kalman: Extended, detector: Detector) -> str:
    """The text of `robot.h`; every number is written to its last bit.

    A change of the robot adds the covariance of the CAD values.
    """
    prior, change = cad_prior(robot), factor_of(cad_covariance(robot, UNCERTAINTY))
    tables = _core.flight_tables(kalman.core)
    memory, state = _core.flight_memory(kalman.core, detector.window)
    sets, own = kalman.sets, kalman.sets.regressors
    sigmas, iotas = sets.base.sigmas, sets.iotas
    joints, wheels = len(robot.joints), len(robot.wheels)
    sparse = {name: _sparse(name, *tables[name]) for name in SPARSE}
    arrays = [
        *(made for made, _ in sparse.values()),
        _whole("PRODUCT", tables["product"]),
        _whole("PAIR", tables["pair"]),
        reals("BETA", prior.beta),
        reals("ROOT", prior.root),
        reals("OPENING", change),
    ]
    if joints:
        arrays.append(_list("orbident_joint", "JOINT", map(_joint, robot.joints)))
    if wheels:
        arrays.append(_list("orbident_wheel", "WHEEL", map(_wheel, robot.wheels)))
    driven, longest = kalman.noise.driven
    if len(driven):
        arrays.append(_list("orbident_driven", "DRIVEN", map(_driven, driven)))
    body = "\n".join(arrays)
    named = {name: reference for name, (_, reference) in sparse.items()}
    # A number of this table, at least 1, that a float holds exactly.
    mark = 1 + zlib.crc32(f"{robot.name}\n{body}".encode()) % (2**24 - 1)
    fields = [
        f"{mark}L, {joints}, {wheels}",
        f"{'ROBOT_JOINT' if joints else '0'}, {'ROBOT_WHEEL' if wheels else '0'}",
        f"{named['theta_of_linear']}, {named['theta_of_sigma']}",
        f"ROBOT_PRODUCT, {len(tables['product']) // 2}, {named['theta_of_beta']}",
        f"{_axes(own.momentum_axes)}, {_axes(own.velocity_axes)}",
        f"{{{_reals(kalman.noise[:11])}}}, {int(kalman.noise.accelerometer)}",
        f"{'ROBOT_DRIVEN' if len(driven) else '0'}, {len(driven)}, {_real(longest)}",
        f"{named['pi_of_shown']}, {named['pi_of_products']}",
        f"ROBOT_PAIR, {len(sets.pi_of_beta)}, {sigmas}, {iotas}",
        "ROBOT_BETA, ROBOT_ROOT, ROBOT_OPENING",
        f"{detector.window}, {_real(detector.threshold)}",
    ]
    return Template(template_text("robot_h.txt")).substitute(
        memory=memory,
        state=state,
        measured=2 * joints + wheels + 16 + len(driven),
        betas=1 + sigmas + iotas,
        meaning="\n".join(_meaning(robot, kalman)),
        body=body,
        fields=",\n    ".join(fields),
    )


def reals(name: str, values: Floats) -> str:
    """A constant array of the filter's scalar, named after the robot."""
    return _list("orbident_real", name, map(_real, np.ravel(values)))


def hexadecimal(value: float) -> str:
    """A number to its last bit, as C and C++ read it."""
    # Hexadecimal floats have no name for what is not a number.
    return float(value).hex() if np.isfinite(value) else "(double)NAN"


def _meaning(robot: Robot, kalman: Extended) -> list[str]:
    base = formulas_of(robot, kalman.sets).base
    pairs = zip(base.names, base.formulas, strict=True)
    lines = (" = ".join(dict.fromkeys(pair)) for pair in pairs)
    # No name of a body may end the comment.
    return [f"/*   {line.replace('*/', '* /')} */" for line in lines]


def _joint(joint: Joint) -> str:
    parts = (joint.axis, joint.R_PJ, joint.p_PJ)
    numbers = ", ".join(f"{{{_reals(part)}}}" for part in parts)
    return f"{{{joint.parent}, {int(joint.kind == 'revolute')}, {numbers}}}"


def _wheel(wheel: Wheel) -> str:
    return f"{{{{{_reals(wheel.axis)}}}, {_real(wheel.inertia)}}}"


def _driven(row: Float[np.ndarray, " numbers"]) -> str:
    joint, walk, still, *drives = row
    half = len(drives) // 2
    known, std = (f"{{{_reals(part)}}}" for part in (drives[:half], drives[half:]))
    return f"{{{int(joint)}, {_reals([walk, still])}, {known}, {std}}}"


def _axes(axes: tuple[int, ...]) -> str:
    three = [*axes, 0, 0][:3]
    return f"{{{', '.join(map(str, three))}}}, {len(axes)}"


def _sparse(
    name: str, first: np.ndarray, row: np.ndarray, value: np.ndarray
) -> tuple[str, str]:
    """The arrays of a sparse matrix, and how the robot's table refers to them."""
    names = [f"{name.upper()}_{part}" for part in ("FIRST", "ROW", "VALUE")]
    arrays = [_whole(names[0], first), _whole(names[1], row), reals(names[2], value)]
    parts = ", ".join(f"ROBOT_{part}" for part in names)
    return "\n".join(arrays), f"{{{parts}, {len(first) - 1}}}"


def _whole(name: str, values: np.ndarray) -> str:
    return _list("int", name, (str(int(value)) for value in values))


def _list(kind: str, name: str, items: Iterable[str]) -> str:
    # An array has at least one entry in C.
    every = list(items) or ["0"]
    rows = [", ".join(every[k : k + PER_LINE]) for k in range(0, len(every), PER_LINE)]
    inside = ",\n    ".join(rows)
    return f"ORBIDENT_CONSTANT {kind} ROBOT_{name}[] = {{\n    {inside}}};"


def _reals(values: Floats) -> str:
    return ", ".join(map(_real, np.ravel(values)))


def _real(value: float) -> str:
    return f"R({hexadecimal(value)})"


SOURCES = Path(_core.__file__).parent / "flight"
"""What is copied, as it was installed with the core."""

MOST = 2000
"""Steps that are replayed: a compiler takes a second for so many golden numbers."""

GOLDEN = "golden.h"
"""What `replay` compares with: every folder that was written has it."""

_INCLUDED = re.compile(r'^#include "(orbident/\w+\.hp?p?)"', re.MULTILINE)


class Flight(NamedTuple):
    """A folder that was written."""

    steps: int
    """How many steps of the recording `replay` takes."""
    memory: int
    """Numbers of a filter: 8 bytes each with double, 4 with float."""
    state: int
    """Those of them that are kept to go on later."""
    scale: bool
    """Whether the recording tells the scale of the parameters."""


def export_flight(
    robot: Robot,
    samples: Samples,
    torques: Torques,
    h_cm: Float[np.ndarray, "3"] | None,
    folder: Path,
    force: bool = False,
) -> Flight:
    """Write the filter of a robot and its sensors, and what it makes of a recording.

    The filter starts from nominal inertia, with 30 % uncertainty; the samples say how
    noisy the sensors are, and are replayed, with the torques at joints. `h_cm` is the
    momentum where it is known, inertial axes, N m s. With `force` the folder may be one
    that this function wrote; what else is in it stays.

    Raises:
        InputError: no sample is complete, or the folder holds something or cannot be
            written.
    """
    check_empty(folder, force)
    given = filter_input_of(robot, samples, torques)
    kalman = Extended.of(robot, given.noise)
    detector = Detector(kalman.rows, samples=given.t.size)
    seen = filter_history(robot, kalman, detector, given, h_cm)
    replayed = {"TIME": given.t, "SAMPLE": given.samples, "BETA": seen.beta}
    replayed["STATISTIC"] = seen.tests[:, 2] / detector.threshold
    golden = {name: table[:MOST] for name, table in replayed.items()}
    made = {
        "robot.h": robot_header(robot, kalman, detector),
        GOLDEN: _golden(golden, h_cm),
    }
    copied = dict(_copied())
    with replacing_files(folder, [*copied, *made]) as new:
        check_empty(folder, force)
        for name, source in copied.items():
            (new / name).parent.mkdir(parents=True, exist_ok=True)
            copyfile(source, new / name)
        for name, text in made.items():
            (new / name).write_text(text, encoding="utf-8")
    memory, state = _core.flight_memory(kalman.core, detector.window)
    return Flight(len(golden["TIME"]), memory, state, seen.scale)


def check_empty(folder: Path, force: bool = False) -> None:
    """Refuse a folder that holds anything; with `force`, anything else than a filter.

    Raises:
        InputError: it does, or is a file.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; name a folder")
    if not folder.is_dir() or all(x.name.startswith(".") for x in folder.iterdir()):
        return
    if not (folder / GOLDEN).is_file():
        raise InputError(
            f"{folder}: holds something else than a filter for flight, so nothing is "
            "written there; name another folder"
        )
    if not force:
        raise InputError(f"{folder}: exists already; name another, or use --force")


def _copied() -> Iterator[tuple[str, Path]]:
    """Where in the folder a file goes, and where it is."""
    for top in (SOURCES, SOURCES / "eigen"):
        for path in sorted(top.glob("**/*" if top.name == "eigen" else "*")):
            if path.is_file():
                yield str(path.relative_to(SOURCES)), path
    for name in sorted(_headers("orbident/flight.hpp", set())):
        yield f"include/{name}", SOURCES / "include" / name


def _headers(name: str, known: set[str]) -> set[str]:
    """A header and all of ours that it includes."""
    if name not in known:
        known.add(name)
        text = (SOURCES / "include" / name).read_text(encoding="utf-8")
        for included in _INCLUDED.findall(text):
            _headers(included, known)
    return known


def _golden(
    tables: Mapping[str, np.ndarray], h_cm: Float[np.ndarray, "3"] | None
) -> str:
    """The text of `golden.h`, from tables with a row a step."""
    momentum = "static const orbident_real* const GOLDEN_MOMENTUM = 0;"
    if h_cm is not None:
        known = ", ".join(f"(orbident_real){hexadecimal(h)}" for h in h_cm)
        momentum = f"static const orbident_real GOLDEN_MOMENTUM[] = {{{known}}};"
    return Template(template_text("golden_h.txt")).substitute(
        steps=len(tables["TIME"]),
        tables="\n".join(
            f"static const double GOLDEN_{name}[] = {_rows(table)};"
            for name, table in tables.items()
        ),
        momentum=momentum,
    )


def _rows(table: np.ndarray) -> str:
    """A row of the table a line."""
    rows = table.reshape(len(table), -1)
    return "{\n" + ",\n".join(", ".join(map(hexadecimal, row)) for row in rows) + "}"


def samples_for_flight(
    source: Result | Robot, recording: Recording
) -> tuple[Robot, Samples, Torques, Float[np.ndarray, "3"] | None]:
    """The robot, samples and torques as `identify` has them; known momentum (N m s).

    Of a result its robot, its clocks and its knowledge of the momentum count; of a
    robot's momentum nothing is known.

    Raises:
        InputError: a column is missing, or there are too few samples.
    """
    robot = source.robot if isinstance(source, Result) else source
    require_measured(robot, "the filter")
    check_regular(robot)
    clean = screened(robot, recording.with_joints_of(robot)).recording
    of_result = isinstance(source, Result)
    clocks = source.clocks if of_result else base_clocks(robot, clean)
    late = corrections(clocks)
    samples = samples_of(robot, clean, late)
    torques = torques_of(robot, clean, samples, late)
    if not of_result or source.initial_momentum != "at-rest":
        return robot, samples, torques, None
    known = known_momentum(robot, minimal_sets(robot), samples, "at-rest")
    return robot, samples, torques, None if known is None else np.asarray(known.h)
