"""The recursive filter of one robot as a folder of C and C++, with golden vectors.

The folder holds the code that Python runs. A flight computer gets the samples as the
filter takes them: `given_of` makes them of a recording, on the ground.

Which samples of a recording a flight build replays: those of the recursion.
"""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from shutil import copyfile
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from orbident import _core
from orbident.errors import InputError
from orbident.estimation.clocks import base_clocks
from orbident.estimation.linear_fits import known_momentum
from orbident.estimation.recursive.changes import Detector
from orbident.estimation.recursive.filter import Extended
from orbident.estimation.recursive.given import given_of
from orbident.estimation.recursive.history import filter_history
from orbident.estimation.recursive.prior import (
    UNCERTAINTY,
    cad_covariance,
    cad_prior,
    factor_of,
)
from orbident.estimation.result import Result
from orbident.files.folder_replacing import replacing_files
from orbident.identified.flight_tables import hexadecimal, robot_header
from orbident.model.minimal_sets import minimal_sets
from orbident.model.regularity import check_regular
from orbident.preprocessing.delays import corrections
from orbident.preprocessing.samples import Samples, samples_of
from orbident.preprocessing.screening import screened
from orbident.recordings.recording import Recording
from orbident.robot.description import Robot

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
    h_cm: Float[np.ndarray, "3"] | None,
    folder: Path,
    force: bool = False,
) -> Flight:
    """Write the filter of a robot and its sensors, and what it makes of a recording.

    Args:
        robot: the filter starts from its nominal inertia, with 30 % uncertainty.
        samples: of a recording; they say how noisy the sensors are, and are replayed.
        h_cm: the momentum where it is known, inertial axes, N m s.
        folder: that does not exist, or is empty.
        force: also one that this function has written; what else is in it stays.

    Raises:
        InputError: no sample is complete, or the folder holds something or cannot be
            written.
    """
    check_empty(folder, force)
    given = given_of(robot, samples)
    kalman = Extended.of(robot, given.noise)
    detector = Detector(kalman.rows, samples=given.t.size)
    seen = filter_history(robot, kalman, detector, given, h_cm)
    statistic = seen.tests[:, 2] / detector.threshold
    golden = {"TIME": given.t, "SAMPLE": given.samples, "BETA": seen.beta}
    golden["STATISTIC"] = statistic
    change = factor_of(cad_covariance(robot, UNCERTAINTY))
    made = {
        "robot.h": robot_header(robot, kalman, cad_prior(robot), change, detector),
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
    return Flight(min(given.t.size, MOST), memory, state, seen.scale)


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
        deep = "**/*" if top.name == "eigen" else "*"
        for path in sorted(top.glob(deep)):
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
    steps = min(len(tables["TIME"]), MOST)
    lines = [
        "/* Samples of a recording, as the filter takes them, and what Python's filter",
        " * makes of each: the estimate, and the statistic of a change. */",
        "#ifndef ORBIDENT_GOLDEN_H",
        "#define ORBIDENT_GOLDEN_H",
        "",
        "#include <math.h>",
        '#include "orbident/flight.h"',
        "",
        f"#define GOLDEN_STEPS {steps}",
        *(f"static const double GOLDEN_{n}[] = {_rows(x)};" for n, x in tables.items()),
    ]
    if h_cm is None:
        lines.append("static const orbident_real* const GOLDEN_MOMENTUM = 0;")
    else:
        known = ", ".join(f"(orbident_real){hexadecimal(h)}" for h in h_cm)
        lines.append(f"static const orbident_real GOLDEN_MOMENTUM[] = {{{known}}};")
    return "\n".join([*lines, "", "#endif", ""])


def _rows(table: np.ndarray) -> str:
    """A row of the table a line."""
    rows = table[:MOST].reshape(min(len(table), MOST), -1)
    return "{\n" + ",\n".join(", ".join(map(hexadecimal, row)) for row in rows) + "}"


def samples_for_flight(
    source: Result | Robot, recording: Recording
) -> tuple[Robot, Samples, Float[np.ndarray, "3"] | None]:
    """Screen a recording and derive what it lacks, as `identify` does.

    Args:
        source: a result, whose robot, clocks and knowledge of the momentum count; or a
            robot, of whose momentum nothing is known.
        recording: of the free-floating robot.

    Returns:
        The robot, its samples, and the momentum where it is known (N m s).

    Raises:
        InputError: a column is missing, or there are too few samples.
    """
    robot = source.robot if isinstance(source, Result) else source
    check_regular(robot)
    clean = screened(robot, recording.with_joints_of(robot)).recording
    if not isinstance(source, Result):
        clocks = base_clocks(robot, clean)
        return robot, samples_of(robot, clean, corrections(clocks)), None
    samples = samples_of(robot, clean, corrections(source.clocks))
    if source.initial_momentum != "at-rest":
        return robot, samples, None
    known = known_momentum(robot, minimal_sets(robot), samples, "at-rest")
    return robot, samples, None if known is None else np.asarray(known.h)
