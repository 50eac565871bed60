import errno
import json
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_campaigns import begun, no_paper_motion, rows, write_campaign

from orbident.campaigns import conduct as conducting
from orbident.campaigns.conduct import (
    Done,
    campaign_progress,
    conduct,
    failed_runs,
    repeat_run,
    run_chunk,
)
from orbident.campaigns.executors import InThisProcess
from orbident.campaigns.folder import Campaign, begin, opened, path_of
from orbident.campaigns.spec import load_spec
from orbident.campaigns.statistics import method_statistics
from orbident.errors import InputError
from orbident.report.campaign_page import campaign_report
from orbident.trajectories.trajectory import InitialState
from orbident.trajectories.trajectory_file import load_trajectory, save_trajectory


def test_two_motions_of_one_robot_are_told_apart(tmp_path: Path):
    entry = {"robot": "robot.yaml", "trajectory": "motion.yaml"}
    pushed = entry | {"environment": {"torque": ["1 mN m", 0, 0]}}
    campaign, out = begun(tmp_path / "a", robots=[entry, pushed], runs=2)
    conduct(campaign, out, InThisProcess, lambda _: None)
    names = ["paper-spatial (1)", "paper-spatial (2)"]
    table = rows(campaign, out)
    assert table["robot"].to_pylist() == names
    assert [each.robot for each in method_statistics(table)] == names
    for name in names:
        assert name in campaign_report(campaign, out, table)


def test_rows_do_not_depend_on_chunks_or_order(tmp_path: Path):
    campaign, out = begun(tmp_path / "a")
    seen: list[Done] = []
    assert conduct(campaign, out, InThisProcess, seen.append) == (3, 3, 0)
    assert [done.runs for done in seen] == [0, 1, 2, 3]
    table = rows(campaign, out)
    assert table["run"].to_pylist() == [0, 1, 2]
    assert set(table["level"].to_pylist()) <= {"trust", "with care", "do not trust"}

    other, elsewhere = begun(tmp_path / "b", chunk=2)
    # Two threads, in whatever order they are done.
    conduct(other, elsewhere, lambda: ThreadPoolExecutor(2))
    assert rows(other, elsewhere).equals(table)


def test_what_is_done_is_not_done_again(tmp_path: Path, monkeypatch):
    campaign, out = begun(tmp_path)
    conduct(campaign, out, InThisProcess)
    table = rows(campaign, out)
    made = []
    path_of(out, range(1, 2)).unlink()
    assert campaign_progress(campaign, out) == (2, 3, 0)

    def watched(campaign: Campaign, runs: range):
        made.append(runs)
        return run_chunk(campaign, runs)

    monkeypatch.setattr(conducting, "run_chunk", watched)
    assert conduct(opened(out), out, InThisProcess) == (3, 3, 0)
    assert made == [range(1, 2)]
    assert rows(campaign, out).equals(table)


def test_a_run_that_raises_is_one_file(tmp_path: Path):
    write_campaign(tmp_path)
    motion = load_trajectory(tmp_path / "motion.yaml")
    # rad/s: too fast for five samples a second.
    tumbling = InitialState(angular_velocity=np.full(3, 30.0))
    save_trajectory(replace(motion, initial=tumbling), tmp_path / "fast.yaml")
    robots = [
        {"robot": "robot.yaml", "trajectory": f"{name}.yaml"}
        for name in ("motion", "fast")
    ]
    campaign, out = begun(tmp_path, robots=robots)
    assert conduct(campaign, out, InThisProcess) == (3, 3, 1)
    (path,) = failed_runs(out)
    assert path.name == "1.json"
    failure = json.loads(path.read_text())
    assert failure["error"] == "InputError"
    assert "turns" in failure["reason"]
    assert failure["draws"] == campaign.case(1).draws
    assert rows(campaign, out)["run"].to_pylist() == [0, 2]


class _Dying(Executor):
    """Its workers die before any is done, so many times."""

    def __init__(self, deaths: list[int]) -> None:
        self.deaths = deaths

    def submit(self, fn, /, *args, **kwargs) -> Future:
        future = Future()
        if self.deaths[0]:
            self.deaths[0] -= 1
            future.set_exception(BrokenExecutor("a process was ended"))
        else:
            future.set_result(fn(*args, **kwargs))
        return future


def test_workers_that_die_are_replaced(tmp_path: Path):
    campaign, out = begun(tmp_path, runs=1)
    left = [2]
    assert conduct(campaign, out, lambda: _Dying(left)) == (1, 1, 0)


def test_workers_that_always_die_are_given_up(tmp_path: Path):
    campaign, out = begun(tmp_path, runs=2)
    with pytest.raises(InputError, match="workers ended 3 times in a row"):
        conduct(campaign, out, lambda: _Dying([99]))
    assert campaign_progress(campaign, out) == (0, 2, 0)


def test_a_full_disk_loses_nothing(tmp_path: Path, monkeypatch):
    campaign, out = begun(tmp_path, runs=2)
    write = conducting.write_rows

    def full(path: Path, *rest) -> None:
        if path.stem.endswith("1"):
            with conducting_write(path):
                raise OSError(errno.ENOSPC, "No space left on device")
        write(path, *rest)

    monkeypatch.setattr(conducting, "write_rows", full)
    with pytest.raises(InputError, match="free some space"):
        conduct(campaign, out, InThisProcess)
    assert campaign_progress(campaign, out) == (1, 2, 0)
    monkeypatch.setattr(conducting, "write_rows", write)
    assert conduct(campaign, out, InThisProcess) == (2, 2, 0)


@contextmanager
def conducting_write(path: Path) -> Iterator[None]:
    from orbident.files.replacing import replacing

    with replacing(path) as temporary:
        temporary.write_bytes(b"half")
        yield


def test_another_campaign_is_not_mixed_in(tmp_path: Path):
    begun(tmp_path)
    with pytest.raises(InputError, match=r"holds another campaign \('spec.yaml'"):
        begun(tmp_path, entropy=2)
    (tmp_path / "out" / "spec.yaml").write_text("runs: 1")
    with pytest.raises(InputError, match="was changed since the campaign began"):
        opened(tmp_path / "out")


def test_other_versions_are_not_mixed_in(tmp_path: Path):
    _, out = begun(tmp_path)
    path = out / "campaign.json"
    manifest = json.loads(path.read_text())
    manifest["versions"]["numpy"] = "1.0"
    path.write_text(json.dumps(manifest))
    with pytest.raises(InputError, match=r"was begun with 'numpy' '1\.0'"):
        begun(tmp_path)


@pytest.mark.parametrize(
    "manifest",
    ["", "[]", '{"schema": "x"}', '{"schema": "orbident/campaign-folder/1"}'],
)
def test_a_damaged_folder_is_refused(tmp_path: Path, manifest: str):
    _, out = begun(tmp_path)
    (out / "campaign.json").write_text(manifest)
    with pytest.raises(InputError, match="is damaged"):
        opened(out)


def test_a_damaged_chunk_is_refused(tmp_path: Path):
    campaign, out = begun(tmp_path, runs=1)
    conduct(campaign, out, InThisProcess)
    path_of(out, range(1)).write_bytes(b"PAR1")
    with pytest.raises(InputError, match="remove it and run the campaign again"):
        rows(campaign, out)


def test_a_chunk_whose_column_names_are_no_text_is_refused(tmp_path: Path):
    campaign, out = begun(tmp_path, runs=1)
    conduct(campaign, out, InThisProcess)
    chunk = path_of(out, range(1))
    # Not UTF-8: the fuzzer found such a file.
    chunk.write_bytes(chunk.read_bytes().replace(b"robot", b"\xdaobot"))
    with pytest.raises(InputError, match="remove it and run the campaign again"):
        rows(campaign, out)


def test_a_folder_of_another_kind_is_left_alone(tmp_path: Path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="is not a campaign's folder"):
        begun(tmp_path)
    with pytest.raises(InputError, match="is not a campaign's folder"):
        opened(tmp_path / "out")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["notes.txt"]


def test_one_run_again(tmp_path: Path):
    campaign, out = begun(tmp_path, runs=2)
    conduct(campaign, out, InThisProcess)
    again = repeat_run(campaign, out, 1)
    assert again.same
    assert again.path == out / "rerun" / "1" / "recording.parquet"
    assert again.results["least-squares"].input["seed"] == campaign.case(1).seed
    path_of(out, range(1, 2)).unlink()
    assert repeat_run(campaign, out, 1).same is None
    with pytest.raises(InputError, match="has runs 0 to 1"):
        repeat_run(campaign, out, 2)


def test_a_file_that_a_campaign_names_is_missing(tmp_path: Path):
    path = tmp_path / "campaign.yaml"
    begun(tmp_path)
    path.write_text(path.read_text().replace("robot.yaml", "other.yaml"))
    with pytest.raises(InputError, match=r"robots\[0\]: .*other.yaml"):
        begin(load_spec(path), tmp_path / "new", no_paper_motion)
    assert not (tmp_path / "new").exists()
