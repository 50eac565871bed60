"""The same rows by a Dask cluster with TLS, by two processes and by one; Slurm's jobs.

.venv/bin/pytest -m long tests/statistics/test_campaign_cluster.py
"""

from pathlib import Path

import pytest
from dask_clusters import cluster, tls_settings
from processes import ORBIDENT, finished
from small_campaigns import begun, rows, write_campaign

from orbident.campaigns.conduct import conduct
from orbident.campaigns.executors import InThisProcess, local
from orbident.campaigns.folder import opened

pytestmark = pytest.mark.long

RUNS = 12


def test_a_cluster_with_tls_makes_the_same_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    campaign, one = begun(tmp_path / "one", runs=RUNS)
    conduct(campaign, one, InThisProcess)
    wanted = rows(campaign, one)
    other, two = begun(tmp_path / "two", runs=RUNS, chunk=5)
    conduct(other, two, local(2))
    assert rows(other, two).equals(wanted)

    for name, value in tls_settings(tmp_path).items():
        monkeypatch.setenv(name, value)
    given = write_campaign(tmp_path / "given", runs=RUNS, chunk=1)
    out = tmp_path / "out"
    with cluster() as started:
        where = ("--cluster", started.address)
        ran = finished(*ORBIDENT, "campaign", given, "-o", out, *where, "--quiet")
    assert (ran.returncode, ran.stderr) == (0, "")
    assert rows(opened(out), out).equals(wanted)


def test_what_slurm_is_given(monkeypatch: pytest.MonkeyPatch):
    dask = pytest.importorskip("dask")
    from orbident.campaigns.executors import slurm_cluster

    asked = {"cores": 4, "memory": "8GB", "walltime": "02:00:00", "queue": "long"}
    with (
        dask.config.set({f"jobqueue.slurm.{key}": x for key, x in asked.items()}),
        slurm_cluster() as started_,
    ):
        script = started_.job_script()
    for line in ("--cpus-per-task=4", "-t 02:00:00", "-p long"):
        assert f"#SBATCH {line}" in script
    # Nine tenths of two hours.
    assert "--lifetime 6480s --lifetime-stagger 360s" in script
