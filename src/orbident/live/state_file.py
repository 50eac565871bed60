"""What is carried from sample to sample, in a file: written whole or not at all."""

import io
import json
import zipfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from orbident._core import Watch
from orbident.errors import InputError
from orbident.files.replacing import replacing
from orbident.live.lines import needed_columns
from orbident.live.live_filter import Carried, Running, tools_of
from orbident.robot.description import Robot


def save_state(path: Path, carried: Carried) -> None:
    """Write all of it; a restart goes on with the same bits.

    Raises:
        InputError: the place cannot be written.
    """
    arrays = {
        "past": carried.past,
        "held": carried.held,
        "times": np.array([carried.begin, carried.before, carried.due]),
        "counts": np.array(json.dumps(carried.counts)),
    }
    if (running := carried.running) is not None:
        arrays["dt"] = np.array(running.tools.dt)
        arrays["mark"] = np.array(running.tools.mark)
        arrays["state"] = running.state.numbers
        arrays["watch"] = running.watch.numbers
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **arrays)
    with replacing(path) as temporary:
        temporary.write_bytes(content.getvalue())


def nothing_carried(robot: Robot) -> Carried:
    """Before the first sample."""
    nothing = np.empty((0, len(needed_columns(robot)) + 6))
    return Carried(nothing, nothing)


def read_state(path: Path, robot: Robot, velocity_std: float | None) -> Carried:
    """Read it back, or nothing where there is no such file.

    Args:
        path: of the file.
        robot: whose it is.
        velocity_std: of a velocity sample, m/s.

    Raises:
        InputError: it is no such file, is damaged, or is of another robot or noise.
    """
    if not path.exists():
        return nothing_carried(robot)
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        begin, before, due = map(float, arrays["times"])
        counts = Counter(json.loads(str(arrays["counts"])))
        past, held = arrays["past"], arrays["held"]
        carried = Carried(past, held, None, begin, before, due, counts)
        if "dt" in arrays:
            carried.running = _running(path, robot, velocity_std, arrays)
    except InputError:
        raise
    except (OSError, ValueError, KeyError, zipfile.BadZipFile, EOFError):
        raise InputError(
            f"{path}: is no state of a filter, or is damaged; name another file, or "
            "remove this one to begin anew"
        ) from None
    if carried.held.shape[1:] != nothing_carried(robot).held.shape[1:]:
        raise InputError(_another(path))
    return carried


def _running(
    path: Path,
    robot: Robot,
    velocity_std: float | None,
    arrays: Mapping[str, np.ndarray],
) -> Running:
    tools = tools_of(robot, float(arrays["dt"]), velocity_std)
    if str(arrays["mark"]) != tools.mark:
        raise InputError(_another(path))
    rows, window = tools.detector.rows, tools.detector.window
    state = tools.kalman.core.restored(arrays["state"])
    return Running(tools, state, Watch.restored(rows, window, arrays["watch"]))


def _another(path: Path) -> str:
    return (
        f"{path}: is the state of another robot, or of other sensors or another "
        "--velocity-std; name another file, or remove this one to begin anew"
    )
