"""What a run of the command left, and what is expected of it."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from orbident.identified.run_folder import FILES, OWN, READ, with_checksums
from orbident.recordings.recording import Recording
from orbident.recordings.tables import write_recording

LINEAR = ("--method", "least-squares")
"""Where the method is not the point: it needs the least time."""


class Ran(NamedTuple):
    """A finished run."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """Standard output, which must be one JSON document and nothing else."""
        return json.loads(self.out)

    def done(self) -> "Ran":
        """Status 0, and nothing on standard error."""
        assert self.err == ""
        assert self.status == 0
        return self

    def refused(self, *words: object) -> str:
        """Status 2 and one line that holds these words; the line."""
        assert self.status == 2, self.err
        return self._one_line(words)

    def untrusted(self) -> "Ran":
        """Status 1: it ran, and says that its result must not be trusted."""
        assert self.err == ""
        assert self.status == 1
        return self

    def _one_line(self, words: Sequence[object]) -> str:
        assert self.err.startswith("orbident: ")
        assert self.err.endswith("\n")
        assert self.err.count("\n") == 1, self.err
        assert self.out == ""
        assert "internal error" not in self.err
        for word in words:
            assert str(word) in self.err
        return self.err


Orbident = Callable[..., Ran]


def written(
    recording: Recording,
    path: Path | str,
    drop: Sequence[str] = (),
    replace: Mapping[str, np.ndarray] | None = None,
    rows: slice = slice(None),
) -> Path:
    """A recording as a file, with columns dropped, replaced or added.

    Args:
        recording: what to write.
        path: where; the suffix says how.
        drop: columns, or how their names begin.
        replace: columns instead of, or beside, those that are there.
        rows: which of them.
    """
    columns = {
        name: values
        for name, values in {**recording.columns, **(replace or {})}.items()
        if not any(name.startswith(start) for start in drop)
    }
    varied = Recording(
        recording.t[rows], {name: column[rows] for name, column in columns.items()}
    )
    write_recording(varied, path)
    return Path(path)


def resealed(run: Path) -> None:
    """A RUN whose files were edited gets the checksums of what it now is."""
    path = run / "result.json"
    document = json.loads(path.read_text())
    bare = {key: document[key] for key in document if key not in {FILES, OWN}}
    path.write_text(json.dumps(with_checksums(bare, run, READ)))


def worst_error(found: Mapping[str, Any], true: Mapping[str, Any]) -> float:
    """Largest error of the parameters that were determined, over the set's largest.

    Args:
        found: `pi`, `phi` or `base` of `identify --json`.
        true: the same of `inspect --json`.
    """
    assert found["names"] == true["names"]
    assert found["formulas"] == true["formulas"]
    largest = max(map(abs, true["values"]))
    pairs = zip(found["values"], true["values"], strict=True)
    errors = [abs(value - truth) for value, truth in pairs if value is not None]
    return max(errors, default=0.0) / largest


def missing(found: Mapping[str, Any]) -> list[str]:
    """The names of what was not determined; its std is null too."""
    rows = zip(found["names"], found["values"], found["std"], strict=True)
    names = []
    for name, value, std in rows:
        assert (value is None) == (std is None)
        assert value is None or math.isfinite(value)
        if value is None:
            names.append(name)
    return names


def check_recovered(
    result: Mapping[str, Any], inspected: Mapping[str, Any], tolerance: float
) -> None:
    """Everything was determined, and is right to this relative error."""
    assert result["warnings"] == inspected["warnings"]
    assert result["status"] == "ok"
    for name in ("pi", "phi", "base"):
        assert missing(result[name]) == []
        assert worst_error(result[name], inspected[name]) < tolerance, name
    assert abs(result["mass"]["value"] / inspected["mass"] - 1) < tolerance
