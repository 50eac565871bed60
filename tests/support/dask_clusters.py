"""A Dask cluster on this machine, over TCP with TLS, in processes that end with it."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from processes import finished, started

SCHEDULER = """
import os, sys
from distributed import LocalCluster, Security
if __name__ == "__main__":
    with LocalCluster(
        n_workers=2, threads_per_worker=1, protocol="tls://", security=Security(),
        dashboard_address=None, worker_dashboard_address=None,
    ) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


def tls_settings(folder: Path) -> dict[str, str]:
    """Dask's own settings in the environment: new certificates, which all must have."""
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    request = [
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-subj",
        "/CN=localhost",
    ]
    made = finished(
        "openssl", *request, "-keyout", key, "-out", certificate, limit=60.0
    )
    assert made.returncode == 0, made.stderr
    settings = {"REQUIRE_ENCRYPTION": "True", "TLS__CA_FILE": str(certificate)}
    for who in ("SCHEDULER", "WORKER", "CLIENT"):
        settings[f"TLS__{who}__KEY"] = str(key)
        settings[f"TLS__{who}__CERT"] = str(certificate)
    return {f"DASK_DISTRIBUTED__COMM__{name}": x for name, x in settings.items()}


LIFE = 3600.0
"""s; a campaign after the other may run on it."""


class Cluster:
    """A scheduler, and the two workers that it starts again when they die."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        self.process = process
        self.address = process.stdout.readline().strip()
        assert self.address.startswith("tls://")


@contextmanager
def cluster() -> Iterator[Cluster]:
    """One with the settings of this process's environment."""
    command = (sys.executable, "-c", SCHEDULER)
    with started(command=command, stdin=subprocess.PIPE, limit=LIFE) as process:
        yield Cluster(process)
