"""Text tables as laboratories and satellites write them, by the command."""

from pathlib import Path

import numpy as np
from running import LINEAR, Orbident, check_recovered

from orbident.recordings.recording import Recording
from orbident.recordings.tables import read_recording, write_recording


def check_identified(orbident: Orbident, recording: str, tolerance: float) -> None:
    ran = orbident("identify", "paper-spatial", recording, *LINEAR, "--json", "-")
    inspected = orbident("inspect", "paper-spatial", "--json", "-").done().json
    check_recovered(ran.done().json, inspected, tolerance)


def test_a_recording_of_a_german_laboratory(orbident: Orbident, flight: Recording):
    """Comments, semicolons, decimal commas and a row of units: the same numbers."""
    write_recording(flight, Path("plain.csv"))
    header, *rows = Path("plain.csv").read_text().splitlines()
    assert ";" not in header
    units = ["s", *("" for _ in flight.columns)]
    lines = ["# air bearing", "% schema=1", header.replace(",", ";"), ";".join(units)]
    lines += [row.replace(",", ";").replace(".", ",") for row in rows]
    Path("r.csv").write_text("\n".join(lines))
    again = read_recording("r.csv")
    for name, column in flight.columns.items():
        np.testing.assert_array_equal(again.column(name), column)
    check_identified(orbident, "r.csv", 1e-6)


MAP = """\
schema: orbident/topic-map/1
topics:
  - topic: /
    type: table
    stamp: {RW_TIME: us}
    take:
      gyro: deg/s
      attitude: quaternion
      position: mm
    fields:
      gyro: 2e-8 * w
      attitude: 5e-10 * q
      position: 1e-4 * p + 1000
    frame: base
    point: S
"""


def test_counts_and_a_counter_that_begins_again(orbident: Orbident, flight: Recording):
    """uint32 of microseconds ends after 30 s of the 40; vectors stand in one cell."""
    joints = [f"joint.{name}.position" for name in ("joint1", "joint2", "joint3")]
    wheels = [f"wheel.rw_{axis}.speed" for axis in "xyz"]
    counts = {
        "w": np.round(np.degrees(flight.vector("gyro")) / 2e-8),
        "q": np.round(flight.vector("attitude", "xyzw") / 5e-10),
        "p": np.round((1e3 * flight.vector("position") - 1000) / 1e-4),
    }
    us = (2**32 - 30_000_000 + np.round(flight.t * 1e6).astype(np.int64)) % 2**32
    lines = [",".join(["RW_TIME", *counts, *joints, *wheels])]
    for k, time in enumerate(us):
        vectors = [f'"{list(map(int, each[k]))}"' for each in counts.values()]
        single = [repr(float(flight.column(name)[k])) for name in (*joints, *wheels)]
        lines.append(",".join([str(time), *vectors, *single]))
    Path("packets.txt").write_text("\n".join(lines))
    assert "w.0 to .2" in orbident("topics", "packets.txt").done().out
    single = "".join(f"      {name}: rad\n" for name in joints)
    single += "".join(f"      {name}: rad/s\n" for name in wheels)
    same = "".join(f"      {name}: {name}\n" for name in (*joints, *wheels))
    entries = MAP.replace("    fields:\n", f"{single}    fields:\n{same}")
    Path("map.yaml").write_text(entries)
    ran = orbident("convert", "packets.txt", "--map", "map.yaml", "-o", "r.csv")
    assert "/: its time begins again after 4294.967296 s, put right" in ran.done().out
    np.testing.assert_allclose(read_recording("r.csv").t, flight.t, atol=1e-6)
    # Positions have steps of 0.1 um, rates of 0.35 nrad/s.
    check_identified(orbident, "r.csv", 1e-3)


def test_a_clock_that_was_reset(orbident: Orbident, flight: Recording):
    rows = [f"{t % 25:.3f},{t:.3f}" for t in flight.t]
    Path("log.csv").write_text("\n".join(["time,x", *rows]))
    entry = "  - {topic: /, type: table, stamp: {time: s}, take: {gyro.z: rad/s},\n"
    entry += "     fields: {gyro.z: x}, frame: base}\n"
    Path("map.yaml").write_text("schema: orbident/topic-map/1\ntopics:\n" + entry)
    ran = orbident("convert", "log.csv", "--map", "map.yaml", "-o", "r.csv")
    ran.refused("goes back by 24.95 s at sample 501, 24.95 s after the first")
    assert not Path("r.csv").exists()


def test_an_unknown_kind_of_file_says_what_can_be_read(orbident: Orbident):
    Path("log.xyz").write_text("t,x\n0,1\n")
    orbident("topics", "log.xyz").refused(".txt", "or of NASA's 42")
