"""Memory: what identifying 1,000,000 samples of the dual-arm robot needs.

Writes a recording, then identifies it twice, each time in a fresh process: step by
step through the library, and by the command. Fails where the peak of either process,
Python and all, is more than 250 MB above the recording's own size in memory. It takes
some minutes:

    python benchmarks/million_samples.py
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MiB = 2**20
BEYOND = 250e6
DURATION = 1000.0
"""s."""


def main() -> None:
    """Record in one process, identify in two others, and judge."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=1_000_000)
    parser.add_argument("--record", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--identify", type=Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.record:
        record(asked.record, asked.samples)
    elif asked.identify:
        identify_step_by_step(asked.identify)
    else:
        with tempfile.TemporaryDirectory() as folder:
            sys.exit(measure(Path(folder), asked.samples))


def measure(folder: Path, samples: int) -> int:
    """Exit status: 0 where both stay within the bound."""
    path = folder / "recording.parquet"
    itself = [sys.executable, __file__]
    peak_of([*itself, "--record", str(path), "--samples", str(samples)])
    print(f"on disk         {path.stat().st_size / MiB:8.0f} MiB")
    print("\nthe library, step by step")
    library = peak_of([*itself, "--identify", str(path)])
    print("\nthe command: orbident identify dual-arm recording.parquet")
    command = str(Path(sys.executable).with_name("orbident"))
    robot = str(robot_file(folder))
    whole = peak_of(
        [command, "identify", robot, str(path), "--quiet", "--method", "least-squares"]
    )
    size = recording_size(path)
    status = 0
    print()
    for what, peak in (("library", library), ("command", whole)):
        beyond = peak - size
        within = beyond <= BEYOND
        status |= not within
        print(
            f"{what}: {beyond / 1e6:.0f} MB beyond the recording's {size / 1e6:.0f}"
            f" ({'within' if within else 'ABOVE'} {BEYOND / 1e6:.0f} MB)"
        )
    return int(status)


def peak_of(command: list[str]) -> int:
    """Run a process to its end; its peak resident memory, bytes."""
    started = time.perf_counter()
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{' '.join(command)}: failed")
    peak = usage.ru_maxrss * 1024
    print(f"whole process   {peak / MiB:8.0f} MiB peak", end="")
    print(f"  {time.perf_counter() - started:6.1f} s")
    return peak


def robot_file(folder: Path) -> Path:
    """`dual-arm` as a file of its own, its joints without stops."""
    from orbident import load_robot

    robot = load_robot("dual-arm")
    free = {name: {"position": [-1e6, 1e6]} for name in robot.joint_names}
    document = {**robot.document, "urdf": "robot.urdf", "limits": free}
    (folder / "robot.urdf").write_text(robot.urdf)
    # JSON is YAML too.
    path = folder / "robot.yaml"
    path.write_text(json.dumps(document))
    return path


def recording_size(path: Path) -> int:
    """Bytes of its columns in memory."""
    import pyarrow.parquet as parquet

    table = parquet.read_metadata(path)
    return 8 * table.num_rows * table.num_columns


def record(path: Path, samples: int) -> None:
    """Simulate a long manoeuvre and write it."""
    from manoeuvres import dual_arm, excitation

    from orbident import simulate, write_recording

    robot = dual_arm()
    rate = (samples - 1) / DURATION
    write_recording(simulate(robot, excitation(robot, DURATION), rate=rate), path)


def identify_step_by_step(path: Path) -> None:
    """As the command does it, with the memory after each step."""
    from manoeuvres import dual_arm

    from orbident import identify, read_recording

    robot = dual_arm()
    say("imports")
    recording = read_recording(path)
    say("reading")
    result = identify(robot, recording, "least-squares")
    say("identifying")
    error = abs(result.mass.value / robot.mass - 1)
    print(f"{result.status}, {result.samples} samples, mass to {error:.0e}")


def say(after: str) -> None:
    """Resident memory now, and its peak so far."""
    status = Path("/proc/self/status").read_text().split("\n")
    words = [line.split() for line in status if line.endswith("kB")]
    kilobytes = {name.rstrip(":"): int(count) for name, count, _ in words}
    now, peak = (kilobytes[name] / 1024 for name in ("VmRSS", "VmHWM"))
    print(f"{after:15} {now:8.0f} MiB, peak {peak:.0f}", flush=True)


if __name__ == "__main__":
    main()
