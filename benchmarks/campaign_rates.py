"""How many runs a second a campaign makes, with one process and with more.

Each campaign is one command in a folder of its own. It prints runs a second, the start
of Python included, and then by tenths of the campaign after its first file: a rate that
falls shows there. Memory is that of the command and of all its workers. The tables must
be equal, bit for bit.

    python benchmarks/campaign_rates.py --method least-squares --runs 2000
    python benchmarks/campaign_rates.py --runs 20000 --duration 10 --workers 2
"""

import argparse
import json
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa

from orbident.campaigns.folder import ROWS, opened, read_rows
from orbident.studies.paper_tables import spatial_robot, spatial_trajectory
from orbident.trajectories.trajectory_file import save_trajectory

TENTHS = 10


def main() -> None:
    """Run the same campaign with each number of workers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--method", default="least-squares")
    parser.add_argument("--duration", type=float, help="s; the paper's 80 by default")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        spec = written(Path(folder), asked.runs, asked.method, asked.duration)
        tables = [made(spec, workers, asked.runs) for workers in asked.workers]
    sys.exit(not all(table.equals(tables[0]) for table in tables))


def written(folder: Path, runs: int, method: str, duration: float | None) -> Path:
    """The campaign's file: the paper's servicer, its bodies dispersed."""
    trajectory = spatial_trajectory(spatial_robot())
    trajectory = replace(trajectory, duration=duration or trajectory.duration)
    save_trajectory(trajectory, folder / "motion.yaml")
    spec = {
        "schema": "orbident/campaign/1",
        "robots": [{"robot": "paper-spatial", "trajectory": "motion.yaml"}],
        "methods": [method],
        "runs": runs,
        "disperse": {"inertia": {"normal": "10 %"}},
    }
    path = folder / "campaign.yaml"
    path.write_text(json.dumps(spec))
    return path


def made(spec: Path, workers: int, runs: int) -> pa.Table:
    """Run the command and say how fast it was; its table."""
    out = spec.with_name(f"by{workers}")
    command = Path(sys.executable).with_name("orbident")
    arguments = ["campaign", spec, "-o", out, "--workers", str(workers), "--quiet"]
    began, clock = time.perf_counter(), time.time()
    with subprocess.Popen([command, *arguments]) as process:
        memory = Memory(process.pid)
        memory.start()
        if process.wait() != 0:
            sys.exit(f"the command ended with {process.returncode}")
    took = time.perf_counter() - began
    print(f"{workers} workers: {runs} runs in {took:.1f} s, {runs / took:.3g} a second")
    ends = sorted(each.stat().st_mtime for each in (out / ROWS).glob("*.parquet"))
    # The first chunk holds the start of Python in the workers.
    edges = np.unique(np.linspace(0, len(ends) - 1, TENTHS + 1).round().astype(int))
    size = runs / len(ends)
    rates = size * np.diff(edges) / np.diff(np.array(ends)[edges])
    print("  by tenths:", *(f"{rate:.3g}" for rate in rates))
    print(
        f"  start and first chunk {ends[0] - clock:.1f} s, {memory.said()}", flush=True
    )
    return read_rows(opened(out), out)


class Memory(threading.Thread):
    """Watches the memory of a process and of those that it starts."""

    def __init__(self, pid: int) -> None:
        super().__init__(daemon=True)
        self.pid = pid
        self.seen: list[float] = []

    def run(self) -> None:
        """Look once a second, as long as the process is there."""
        while resident := resident_mb(self.pid):
            children = Path(f"/proc/{self.pid}/task/{self.pid}/children")
            self.seen.append(
                resident + sum(map(resident_mb, map(int, children.read_text().split())))
            )
            time.sleep(1.0)

    def said(self) -> str:
        """The peak, and the mean of the second tenth and of the last but one."""
        tenth = max(1, len(self.seen) // TENTHS)
        early = np.mean(self.seen[tenth : 2 * tenth] or self.seen)
        late = np.mean(self.seen[-2 * tenth : -tenth] or self.seen)
        return f"{max(self.seen):.0f} MB at most, {early:.0f} early, {late:.0f} late"


def resident_mb(pid: int) -> float:
    """Resident memory, MB; zero where the process has ended."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0.0
    return 4096 * pages / 1e6


if __name__ == "__main__":
    main()
