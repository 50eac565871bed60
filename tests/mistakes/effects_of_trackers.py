"""What star trackers and motion capture do, from just visible to gross."""

import numpy as np
from edited_recordings import changed
from mistake import Groups, twice
from recordings import SEED, Clean
from scipy.spatial.transform import Rotation
from spoiled import Spoil, Spoiled, spoiled
from wrong_columns import (
    Change,
    columns,
    filtered,
    held,
    in_time,
    low_passed,
    quaternion,
    rounded,
)


def averaged(start: str, rows: int) -> Spoil:
    """The mean of so many rows around each: a pose that comes out of a smoother."""

    def change(column: np.ndarray) -> np.ndarray:
        padded = np.pad(column, rows // 2, mode="edge")
        return np.convolve(padded, np.full(rows, 1 / rows), "valid")[: column.size]

    return columns(start, change)


def lasting(start: str, size: float, time: float) -> Spoil:
    """An error that lasts: of first order (Gauss, Markov)."""
    random = np.random.default_rng(SEED)

    def spoil(clean: Clean) -> Spoiled:
        keep = np.exp(-(clean.t[1] - clean.t[0]) / time)

        def change(column: np.ndarray) -> np.ndarray:
            e = size * random.standard_normal(column.size)
            for k in range(1, e.size):
                e[k] = keep * e[k - 1] + np.sqrt(1 - keep**2) * e[k]
            return column + e

        return columns(start, change)(clean)

    return spoil


def lasting_attitude(angle: float, time: float) -> Spoil:
    """As a star tracker's, about the base's z; rad."""

    def spoil(clean: Clean) -> Spoiled:
        keep = np.exp(-(clean.t[1] - clean.t[0]) / time)
        e = angle * np.random.default_rng(SEED).standard_normal(clean.t.size)
        for k in range(1, e.size):
            e[k] = keep * e[k - 1] + np.sqrt(1 - keep**2) * e[k]
        return quaternion(
            lambda x: (
                Rotation.from_quat(x) * Rotation.from_euler("z", e[:, None])
            ).as_quat()
        )(clean)

    return spoil


def markers_swap(angle: float, part: float) -> Spoil:
    """Degrees: for this part of the time a tracker takes one marker for another."""

    def change(x: np.ndarray) -> np.ndarray:
        row = np.arange(len(x)) / len(x)
        off = angle * ((row > 0.4) & (row < 0.4 + part))
        turned = Rotation.from_euler("z", off[:, None], degrees=True)
        return (Rotation.from_quat(x) * turned).as_quat()

    return quaternion(change)


def late_fixes(part: float) -> Spoil:
    """Each position was taken up to this long before its row, s: a network's delay."""

    def spoil(clean: Clean) -> Spoiled:
        late = part * np.random.default_rng(SEED).random(clean.t.size)
        at = np.maximum.accumulate(np.maximum(clean.t - late, 0.0))
        at = at + 1e-9 * np.arange(at.size)
        true = clean.true._replace(position=clean.at(at).position)
        return spoiled(clean, recording=clean.recorded(true))

    return spoil


def reflections(angle: float) -> Spoil:
    """Degrees: in one of a hundred rows a reflection is taken for a marker."""

    def change(x: np.ndarray) -> np.ndarray:
        random = np.random.default_rng(SEED)
        off = angle * (random.random(len(x)) < 0.01) * random.standard_normal(len(x))
        turned = Rotation.from_euler("z", off[:, None], degrees=True)
        return (Rotation.from_quat(x) * turned).as_quat()

    return quaternion(change)


def late_attitude(time: float) -> Spoil:
    """From a filter of first order that has no model of the motion, s."""

    def spoil(clean: Clean) -> Spoiled:
        def change(x: np.ndarray) -> np.ndarray:
            # Of one sign from row to row.
            signs = np.sign(np.sum(x[1:] * x[:-1], axis=1))
            x = x * np.cumprod(np.append(1.0, signs))[:, None]
            x = filtered(clean.t, time)(x)
            return x / np.linalg.norm(x, axis=1, keepdims=True)

        return quaternion(change)(clean)

    return spoil


def lens(part: float) -> Change:
    """So much too long where the robot is farthest from where it started."""
    return lambda p: p * (1 + part * (p / np.abs(p).max()) ** 2)


def missed(part: float, zeros: bool) -> Spoil:
    """So many positions do not come: the last one is there again, or zeros."""

    def spoil(clean: Clean) -> Spoiled:
        recording = clean.recorded()
        gone = np.random.default_rng(SEED).random(clean.t.size) < part
        gone[0] = False
        row = np.maximum.accumulate(np.where(gone, 0, np.arange(gone.size)))
        names = [name for name in recording.columns if name.startswith("position.")]
        new = {
            name: np.where(gone & zeros, 0.0, recording.columns[name][row])
            for name in names
        }
        return spoiled(clean, recording=changed(recording, new))

    return spoil


OF_TRACKERS: Groups = {
    "tracker": (
        *twice("star tracker's lasting error of {:g} rad over 10 s",
               lambda size: lasting_attitude(size, 10.0), 1e-4, 2e-3,
               cause="noise|lasting|drift*|jump* attitude"),
        *twice("motion capture's lasting error of {:g} m over 5 s",
               lambda size: lasting("position.", size, 5.0), 3e-4, 5e-3,
               cause="noise|lasting|drift*|jump* position"),
        *twice("markers swapped for 10 % of the time, {:g} deg",
               lambda size: markers_swap(size, 0.1), 0.3, 5.0,
               cause="jump*|outlier|swap*|spike|step attitude"),
        *twice("poses from a smoother of {:g} rows",
               lambda size: averaged("position.", int(size)), 5.0, 51.0,
               cause="noise|smooth*|filter* position"),
        *twice("positions from a filter of {:g} s",
               lambda size: low_passed("position.", size), 0.05, 0.5,
               cause="late|clock|delay*|filter* position"),
        *twice("positions up to {:g} s late, each for itself", late_fixes, 0.01, 0.1,
               cause="late|clock|delay*|jitter|noise position"),
        *twice("position rounded to {:g} m",
               lambda size: columns("position.", rounded(size)), 1e-3, 2e-2,
               cause="noise|round*|resol*|step|quanti* position"),
        *twice("mast that swings the marker by {:g} m at 0.7 Hz",
               lambda size: in_time("position.x",
                                    lambda t: size * np.sin(1.4 * np.pi * t)),
               5e-4, 1e-2, cause="noise|vibrat*|swing*|flexib* position"),
        *twice("attitude from a filter of {:g} s", late_attitude, 0.05, 0.5,
               cause="late|clock|delay*|filter* attitude"),
        *twice("reflections turn one attitude in 100 by {:g} deg", reflections,
               0.5, 20.0, cause="outlier|spike|jump* attitude"),
        *twice("positions from a lens that is {:g} off at the edge",
               lambda size: columns("position.", lens(size)), 1e-3, 2e-2,
               cause="scale|lens|distort* position"),
        *twice("camera moves by {:g} m as it gets warm",
               lambda size: in_time("position.x",
                                    lambda t: size * (1 - np.exp(-t / 20))),
               1e-3, 1e-2, cause="drift*|lasting|noise position"),
        *twice("an arm hides the marker for {:g} s: the last position is held",
               lambda size: held("position", 10**6, 8.0, 8.0 + size), 0.3, 3.0,
               cause="repeat*|stale|held|stuck|same position"),
        *twice("positions that do not come are repeated, {:g} of them",
               lambda size: missed(size, False), 0.02, 0.3,
               cause="repeat*|stale|held|same position"),
        *twice("positions that do not come are zeros, {:g} of them",
               lambda size: missed(size, True), 0.01, 0.1,
               cause="outlier|spike|zeros|lost|missing position"),
    ),
}  # fmt: skip
