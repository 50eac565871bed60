"""The folder of a campaign: all of its state is files.

- `campaign.json`: checksums of the frozen files, and the versions of what computes;
- `spec.yaml`, `robot0/` ...: the campaign file, its robots and their trajectories;
- `rows/<first run>.parquet`: a chunk that is done, a row for each run and method;
- `failed/<run>.json`: a run that could not be made, and why;
- `rerun/<run>/`: one run repeated, with its recording and a RUN for each method.
"""

import json
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
import yaml

from orbident.campaigns.case import Case, Subject
from orbident.campaigns.spec import PAPER, RobotEntry, Spec, SpecFile, load_spec
from orbident.errors import InputError
from orbident.estimation.checks import LEVELS
from orbident.estimation.results import versions
from orbident.files.names import quoted
from orbident.files.replacing import finish, replacing, replacing_files, write_text
from orbident.files.text import read_text, sha256
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.robot_file import (
    bundled_robots,
    load_robot,
    load_written_robot,
    write_robot,
)
from orbident.simulation.outside import check_environment
from orbident.trajectories.trajectory import Trajectory
from orbident.trajectories.trajectory_file import load_trajectory, save_trajectory

SPEC, MANIFEST = "spec.yaml", "campaign.json"
ROBOT_FILES = ("robot.urdf", "robot.oem", "robot.yaml", "trajectory.yaml")
"""What a robot's folder may have; the OEM only where its orbit is one."""
ROWS, FAILED, RERUN, REPORT = "rows", "failed", "rerun", "report.html"

PaperMotion = Callable[[Robot], Trajectory]
"""The paper's exciting motion for a robot."""


@dataclass(frozen=True)
class Campaign:
    """What is run, as the folder has it; it goes to the workers whole."""

    spec: Spec
    subjects: tuple[Subject, ...]

    def case(self, k: int) -> Case:
        """Run `k`."""
        random = np.random.SeedSequence(self.spec.entropy, spawn_key=(k,))
        # All 128 bits, as one whole number.
        words = enumerate(random.generate_state(4))
        seed = sum(int(word) << (32 * i) for i, word in words)
        subject = self.subjects[k % len(self.subjects)]
        return Case(k, subject, self.spec.disperse, seed)


def begin(file: SpecFile, folder: Path, paper_motion: PaperMotion) -> Campaign:
    """Freeze a campaign into a folder, or find it there.

    A folder of the same campaign is gone on with; `paper_motion` is for robots without
    a trajectory file of their own.

    Raises:
        InputError: a file that the campaign names cannot be used, or the folder has
            another campaign, or was begun with other versions.
    """
    with tempfile.TemporaryDirectory() as scratch:
        new = Path(scratch)
        _freeze(file, new, paper_motion)
        sums = _sums(new)
        ours = (*sums, MANIFEST)
        finish(folder, ours)
        if (folder / MANIFEST).exists():
            if other := _differing(_manifest(folder)["sha256"], sums):
                raise InputError(
                    f"{folder}: holds another campaign ({quoted(other[0])} differs); "
                    "name another DIR"
                )
            check_versions(folder, versions())
            return opened(folder)
        free = folder.is_dir() and all(x.name[0] == "." for x in folder.iterdir())
        if folder.exists() and not free:
            raise InputError(
                f"{folder}: is not a campaign's folder; name one that is new or empty"
            )
        with replacing_files(folder, ours) as staged:
            for name in sums:
                (staged / name).parent.mkdir(exist_ok=True)
                (staged / name).write_bytes((new / name).read_bytes())
            manifest = {"schema": _SCHEMA, "versions": versions(), "sha256": sums}
            write_text(staged / MANIFEST, json.dumps(manifest, indent=1))
    return opened(folder)


def opened(folder: Path) -> Campaign:
    """The campaign of a folder.

    Raises:
        InputError: there is none, or its files were changed.
    """
    other = _differing(_manifest(folder)["sha256"], _sums(folder))
    if other:
        raise InputError(
            f"{folder}: {quoted(other[0])} was changed since the campaign began; put "
            "it back, or begin another campaign in another folder"
        )
    spec = load_spec(folder / SPEC).spec
    places = [folder / f"robot{k}" for k in range(len(spec.robots))]
    robots = [load_written_robot(at) for at in places]
    names = [robot.name for robot in robots]
    # One robot may fly two trajectories: then its number tells them apart.
    subjects = tuple(
        Subject(
            robot,
            load_trajectory(at / "trajectory.yaml"),
            robot.name if names.count(robot.name) == 1 else f"{robot.name} ({k})",
        )
        for k, (robot, at) in enumerate(zip(robots, places, strict=True), 1)
    )
    return Campaign(spec, subjects)


def check_versions(folder: Path, found: Mapping[str, str], who: str = "this") -> None:
    """Refuse to go on with other versions: numbers would differ in their last digits.

    Raises:
        InputError: the campaign was begun with others.
    """
    begun = _manifest(folder)["versions"]
    other = _differing(begun, found)
    if other:
        was, now = (quoted(each.get(other[0], "unknown")) for each in (begun, found))
        raise InputError(
            f"{folder}: was begun with {quoted(other[0])} {was}, and {who} is {now}, "
            "whose numbers may differ; install that version, or name another folder"
        )


_SCHEMA = "orbident/campaign-folder/1"


def _manifest(folder: Path) -> dict[str, Any]:
    path = folder / MANIFEST
    if not path.is_file():
        raise InputError(
            f"{folder}: is not a campaign's folder; give one that 'orbident campaign "
            "SPEC -o DIR' wrote"
        )
    text = read_text(path)
    with suppress(ValueError, KeyError, TypeError):
        document = json.loads(text)
        if document["schema"] == _SCHEMA and all(
            isinstance(document[key], dict) for key in ("versions", "sha256")
        ):
            return document
    raise InputError(f"{path}: is damaged; begin the campaign in another folder")


def _sums(folder: Path) -> dict[str, str]:
    """Checksums of what a campaign depends on: of what is there, whoever lists it."""
    robots = (at / name for at in folder.glob("robot*") for name in ROBOT_FILES)
    there = (path for path in (folder / SPEC, *robots) if path.is_file())
    return {path.relative_to(folder).as_posix(): sha256(path) for path in there}


def _differing(one: Mapping[str, str], other: Mapping[str, str]) -> list[str]:
    names = sorted({*one, *other})
    return [name for name in names if one.get(name) != other.get(name)]


def _freeze(file: SpecFile, into: Path, paper_motion: PaperMotion) -> None:
    """Write all that the campaign depends on."""
    text = yaml.safe_dump(file.document, sort_keys=False, allow_unicode=True)
    write_text(into / SPEC, text)
    for k, entry in enumerate(file.spec.robots):
        where = f"{file.path}: robots[{k}]"
        robot, trajectory = _flown(entry, file.path.parent, paper_motion, where)
        at = into / f"robot{k}"
        write_robot(robot, at)
        save_trajectory(trajectory, at / "trajectory.yaml")


def _flown(
    entry: RobotEntry, beside: Path, paper_motion: PaperMotion, where: str
) -> tuple[Robot, Trajectory]:
    try:
        known = entry.robot in bundled_robots()
        robot = load_robot(entry.robot if known else beside / entry.robot)
        if entry.trajectory == PAPER:
            trajectory = paper_motion(robot)
        else:
            trajectory = load_trajectory(beside / entry.trajectory)
        trajectory.for_robot(robot)
        if entry.environment is not None:
            trajectory = replace(trajectory, environment=entry.environment)
        if trajectory.environment is not None:
            check_environment(robot, trajectory.environment)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    return robot, trajectory


Row = dict[str, Any]

_ANEW = "remove it and run the campaign again, which computes it anew"

WORDS = ("robot", "method", "level", "refused_by")


def path_of(folder: Path, chunk: range) -> Path:
    """Where a chunk's rows go."""
    return folder / ROWS / f"{chunk.start:08}.parquet"


def done_chunks(campaign: Campaign, folder: Path) -> list[range]:
    """The chunks whose rows are there."""
    return [each for each in campaign.spec.chunks if path_of(folder, each).exists()]


def schema_of(campaign: Campaign) -> pa.Schema:
    """The columns, the same in every chunk.

    `run`, `robot`, `method`, `level` as `identify` gives it, the check that refuses;
    `draw.*` as they were drawn; and of every base parameter `.value`, `.std` and
    `.true`. What there is not is null.
    """
    firsts = range(len(campaign.subjects))
    draws = dict.fromkeys(name for k in firsts for name in campaign.case(k).draws)
    parameters = dict.fromkeys(
        name
        for subject in campaign.subjects
        for name in formulas_of(subject.robot, minimal_sets(subject.robot)).base.names
    )
    return pa.schema(
        [
            ("run", pa.int64()),
            *((name, pa.string()) for name in WORDS),
            *((f"draw.{name}", pa.float64()) for name in draws),
            *(
                (f"{name}.{what}", pa.float64())
                for name in parameters
                for what in ("value", "std", "true")
            ),
        ]
    )


def arrow_table(rows: Sequence[Row], schema: pa.Schema) -> pa.Table:
    """Rows with these columns; NaN is null."""
    columns = [
        pa.array([row.get(field.name) for row in rows], field.type, from_pandas=True)
        for field in schema
    ]
    return pa.Table.from_arrays(columns, schema=schema)


def write_rows(path: Path, rows: Sequence[Row], schema: pa.Schema) -> None:
    """Write a chunk whole or not at all.

    Raises:
        InputError: the place cannot be written.
    """
    table = arrow_table(rows, schema)
    with replacing(path) as temporary, pa.OSFile(os.fsencode(temporary), "wb") as sink:
        parquet.write_table(table, sink, compression="zstd", use_dictionary=False)


def read_rows(
    campaign: Campaign, folder: Path, columns: Sequence[str] | None = None
) -> pa.Table:
    """The rows of all chunks that are done, in the order of runs.

    All columns are read by default.

    Raises:
        InputError: a file is damaged.
    """
    schema = schema_of(campaign)
    tables = [
        read_chunk(campaign, folder, chunk, schema, columns)
        for chunk in done_chunks(campaign, folder)
    ]
    empty = schema.empty_table().select(columns or schema.names)
    return pa.concat_tables([empty, *tables]).combine_chunks()


def read_chunk(
    campaign: Campaign,
    folder: Path,
    chunk: range,
    schema: pa.Schema,
    columns: Sequence[str] | None = None,
) -> pa.Table:
    """The rows of one chunk.

    Raises:
        InputError: the file is damaged, or was not written by this campaign.
    """
    path = path_of(folder, chunk)
    try:
        with pa.OSFile(os.fsencode(path)) as source:
            # A chunk is small: threads would take longer to start than to read it.
            file = parquet.ParquetFile(source)
            found = file.schema_arrow
            table = file.read(columns, use_threads=False)
    except (pa.ArrowException, ValueError, OSError) as error:
        # A name that is no UTF-8 is a ValueError.
        reason = " ".join(str(error).split())[:80]
        raise InputError(f"{path}: cannot be read ({reason}); {_ANEW}") from error
    if found != schema:
        raise InputError(
            f"{path}: has other columns than this campaign, or other types in them; "
            f"{_ANEW}"
        )
    known = {
        "run": chunk,
        "robot": [subject.name for subject in campaign.subjects],
        "method": campaign.spec.methods,
        "level": LEVELS,
    }
    for name in known.keys() & set(table.column_names):
        if not set(table[name].unique().to_pylist()) <= set(known[name]):
            raise InputError(
                f"{path}: column '{name}' has values that are not of this campaign; "
                f"{_ANEW}"
            )
    return table


def column(table: pa.Table, name: str) -> np.ndarray:
    """A column of numbers; null is NaN."""
    return table[name].to_numpy().astype(float)
