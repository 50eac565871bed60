"""The same rows by a Dask cluster with TLS as by one process; what Slurm is given.

.venv/bin/pytest -m long tests/statistics/test_campaign_cluster.py
"""

import os
import random
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import finished, started
from small_campaigns import begun, rows, write_campaign

from orbident.campaigns.conduct import conduct
from orbident.campaigns.executors import InThisProcess
from orbident.campaigns.folder import opened

pytestmark = pytest.mark.long

RUNS = 12

SCHEDULER = """
import os, sys
from distributed import LocalCluster, Security
if __name__ == "__main__":
    with LocalCluster(
        n_workers=2, threads_per_worker=1, protocol="tls://", security=Security(),
        dashboard_address=None, worker_dashboard_address=None,
    ) as cluster:
        print(cluster.scheduler_address, flush=True)
        for worker in cluster.workers.values():
            print(worker.process.pid, flush=True)
        sys.stdin.read()
"""


@pytest.fixture
def tls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Certificates as Dask's own settings name them, for all processes of the test."""
    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    request = (
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-subj",
        "/CN=localhost",
    )
    made = finished(
        "openssl", *request, "-keyout", key, "-out", certificate, limit=60.0
    )
    assert made.returncode == 0, made.stderr
    start = "DASK_DISTRIBUTED__COMM__"
    monkeypatch.setenv(f"{start}REQUIRE_ENCRYPTION", "True")
    monkeypatch.setenv(f"{start}TLS__CA_FILE", str(certificate))
    for who in ("SCHEDULER", "WORKER", "CLIENT"):
        monkeypatch.setenv(f"{start}TLS__{who}__KEY", str(key))
        monkeypatch.setenv(f"{start}TLS__{who}__CERT", str(certificate))


class Cluster:
    """Two workers on this machine, and their scheduler."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        self.process = process
        self.address = process.stdout.readline().strip()
        self.workers = [int(process.stdout.readline()) for _ in range(2)]


@pytest.fixture
def cluster(tls: None) -> Iterator[Cluster]:
    command = (sys.executable, "-c", SCHEDULER)
    with started(command=command, stdin=subprocess.PIPE) as process:
        yield Cluster(process)


def command(given: Path, out: Path, address: str) -> tuple[object, ...]:
    return ("campaign", given, "-o", out, "--cluster", address, "--quiet")


def test_a_cluster_with_tls_makes_the_same_rows(cluster: Cluster, tmp_path: Path):
    campaign, one = begun(tmp_path / "one", runs=RUNS)
    conduct(campaign, one, InThisProcess)
    wanted = rows(campaign, one)

    assert cluster.address.startswith("tls://")
    given = write_campaign(tmp_path / "given", runs=RUNS, chunk=1)
    out = tmp_path / "out"
    orbident = (sys.executable, "-m", "orbident.cli.app")
    ran = finished(*orbident, *command(given, out, cluster.address))
    assert (ran.returncode, ran.stderr) == (0, "")
    assert rows(opened(out), out).equals(wanted)

    # Killed: a worker, whose runs another does, and the scheduler, in one line.
    out, numbers = tmp_path / "killed", random.Random(1)
    with started(*command(given, out, cluster.address)) as process:
        while not list(out.glob("rows/*.parquet")):
            assert process.poll() is None
        os.kill(numbers.choice(cluster.workers), signal.SIGKILL)
        while len(list(out.glob("rows/*.parquet"))) < 4:
            assert process.poll() is None
        cluster.process.kill()
        _, said = process.communicate(timeout=120)
    assert process.returncode == 2
    assert said.count("\n") == 1, said
    assert len(list(out.glob("rows/*.parquet"))) < RUNS
    # By this machine alone, to the end.
    ran = finished(*orbident, "campaign", given, "-o", out, "--quiet")
    assert (ran.returncode, ran.stderr) == (0, "")
    assert rows(opened(out), out).equals(wanted)


def test_what_slurm_is_given(monkeypatch: pytest.MonkeyPatch):
    dask = pytest.importorskip("dask")
    from orbident.campaigns.cluster import slurm_cluster

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
