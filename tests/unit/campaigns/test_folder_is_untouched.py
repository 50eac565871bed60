"""A campaign's folder that somebody else wrote in."""

import json
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml
from ephemeris_files import write_oem
from small_campaigns import begun, no_paper_motion, rows, write_campaign

from orbident.campaigns.conduct import conduct, reason_in
from orbident.campaigns.executors import InThisProcess
from orbident.campaigns.folder import begin, opened, path_of
from orbident.campaigns.spec import load_spec
from orbident.errors import InputError
from orbident.orbits.orbit import Elements


@pytest.mark.parametrize("sums", [{}, {"spec.yaml": "00"}, None])
def test_what_is_checked_is_not_for_the_folder_to_say(tmp_path: Path, sums):
    _, out = begun(tmp_path)
    path = out / "campaign.json"
    manifest = json.loads(path.read_text())
    if sums is None:
        # Reading a device has no end.
        sums = {**manifest["sha256"], "/dev/zero": "00"}
    path.write_text(json.dumps(manifest | {"sha256": sums}))
    with pytest.raises(InputError, match="was changed since the campaign began"):
        opened(out)
    path.write_text(json.dumps(manifest | {"versions": {}}))
    with pytest.raises(InputError, match="was begun with 'numpy' 'unknown'"):
        begun(tmp_path)


@pytest.mark.parametrize(
    ("column", "values"),
    [
        ("run", pa.array([0], pa.int32())),
        ("run", pa.array([7], pa.int64())),
        ("robot", pa.array(["another"])),
        ("method", pa.array([None], pa.string())),
        ("level", pa.array(["fine"])),
    ],
)
def test_rows_that_the_campaign_did_not_write(tmp_path: Path, column: str, values):
    campaign, out = begun(tmp_path, runs=1)
    conduct(campaign, out, InThisProcess)
    path = path_of(out, range(1))
    table = pq.read_table(path)
    altered = table.set_column(table.schema.get_field_index(column), column, values)
    pq.write_table(altered, path)
    with pytest.raises(InputError, match="remove it and run the campaign again"):
        rows(campaign, out)


def test_damaged_rows_are_found_before_others_are_made(tmp_path: Path):
    campaign, out = begun(tmp_path, runs=3)
    last = [*campaign.spec.chunks][-1]
    path_of(out, last).parent.mkdir(exist_ok=True)
    path_of(out, last).write_bytes(b"PAR1 damaged PAR1")
    with pytest.raises(InputError, match="remove it and run the campaign again"):
        conduct(campaign, out, InThisProcess)
    assert [*path_of(out, last).parent.iterdir()] == [path_of(out, last)]


def test_a_robot_on_an_orbit_from_a_file(tmp_path: Path):
    path = write_campaign(tmp_path, runs=1)
    robot = tmp_path / "robot.yaml"
    epoch, t = datetime(2026, 3, 1, tzinfo=UTC), np.arange(-300.0, 301.0, 60.0)
    write_oem(tmp_path / "orbit.oem", epoch, t, Elements(6.8e6, 0.9, 0.01).states(t))
    orbit = {"oem": "orbit.oem", "epoch": epoch.isoformat()}
    document = yaml.safe_load(robot.read_text()) | {"orbit": orbit}
    document["sensors"]["attitude"] = {"angle": "0.02 deg", "rate": "5 Hz"}
    robot.write_text(yaml.safe_dump(document))
    out = tmp_path / "out"
    campaign = begin(load_spec(path), out, no_paper_motion)
    assert conduct(campaign, out, InThisProcess) == (1, 1, 0)
    assert {each.name for each in out.iterdir()} == {
        *("spec.yaml", "campaign.json", "robot0", "rows")
    }
    oem = out / "robot0" / "robot.oem"
    oem.write_text(oem.read_text().replace("SERVICER", "ANOTHER"))
    with pytest.raises(InputError, match=r"'robot0/robot.oem' was changed"):
        opened(out)


def test_a_failure_that_cannot_be_read(tmp_path: Path):
    path = tmp_path / "3.json"
    for text in ("", "[]", '{"run": 3}', "7", "[" * 100_000):
        path.write_text(text)
        with pytest.raises(InputError, match=r"3\.json: is damaged"):
            reason_in(path)
