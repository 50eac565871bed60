"""Files of other tools are converted to a recording and identified, by the command."""

from pathlib import Path

import numpy as np
from log_writers import write_log
from running import LINEAR, Orbident, check_recovered
from scipy.io import savemat

from orbident.recordings.recording import Recording

MAP = """\
schema: orbident/topic-map/1
topics:
  - topic: /arm
    type: table
    stamp: {time: s}
    take:
      joint.joint1.position: deg
      joint.joint2.position: deg
      joint.joint3.position: deg
      joint.joint1.velocity: deg/s
      joint.joint2.velocity: deg/s
      joint.joint3.velocity: deg/s
      wheel.rw_x.speed: rpm
      wheel.rw_y.speed: rpm
      wheel.rw_z.speed: rpm
    fields:
      joint.joint1.position: q.0
      joint.joint2.position: q.1
      joint.joint3.position: q.2
      joint.joint1.velocity: qd.0
      joint.joint2.velocity: qd.1
      joint.joint3.velocity: qd.2
      wheel.rw_x.speed: wheels.0
      wheel.rw_y.speed: wheels.1
      wheel.rw_z.speed: wheels.2
  - topic: /base
    type: table
    stamp: {time: s}
    take: {gyro: rad/s, attitude: quaternion, position: mm}
    fields: {gyro: [w.0, w.1, -w.2], attitude: [x.1, x.2, x.3, x.0], position: p}
    frame: base
    point: S
"""


def as_structs(flight: Recording) -> dict[str, dict[str, np.ndarray]]:
    """A recording as a laboratory may have it: structs, its units, scalar first."""

    def side_by_side(pattern: str, names: str) -> np.ndarray:
        return np.column_stack([flight.column(pattern.format(k)) for k in names])

    base = {
        "time": flight.t + 1e6,
        "w": flight.vector("gyro") * [1, 1, -1],
        "x": flight.vector("attitude", "xyzw")[:, [3, 0, 1, 2]],
        "p": flight.vector("position") * 1e3,
    }
    arm = {
        "time": flight.t + 1e6,
        "q": np.degrees(side_by_side("joint.joint{}.position", "123")),
        "qd": np.degrees(side_by_side("joint.joint{}.velocity", "123")),
        "wheels": side_by_side("wheel.rw_{}.speed", "xyz") * 60 / (2 * np.pi),
    }
    return {"arm": arm, "base": base}


def test_matlab_to_parameters(orbident: Orbident, flight: Recording):
    savemat("flight.mat", as_structs(flight))
    Path("map.yaml").write_text(MAP)
    ran = orbident("convert", "flight.mat", "--map", "map.yaml", "-o", "r.parquet")
    assert "written: r.parquet" in ran.done().out
    ran = orbident("identify", "paper-spatial", "r.parquet", *LINEAR, "--json", "-")
    inspected = orbident("inspect", "paper-spatial", "--json", "-").done().json
    # As from a bag: the velocity of S is by a spline through 20 Hz.
    check_recovered(ran.done().json, inspected, 1e-6)


def test_what_is_in_a_file(orbident: Orbident):
    table = {"time": np.arange(20) / 10, "q": np.zeros((20, 2))}
    write_log("mat", Path(), {"arm": table, "run": {"name": np.array("first")}})
    ran = orbident("topics", "log.mat", "--json", "-", "-o", "map.yaml").done()
    (root, arm) = ran.json["topics"]
    assert root["topic"] == "/"
    assert arm == {
        "topic": "/arm",
        "type": "table",
        "messages": 20,
        "rate": 10.0,
        "names": ["time", "q.0 to .1"],
        # A table has no header beside the time of its rows.
        "offset": None,
        "drift": None,
        "ranges": {"q": [0.0, 0.0]},
    }
    proposal = Path("map.yaml").read_text()
    assert "  # / (table) has nothing to take\n" in proposal
    assert "  - topic: /arm\n    type: table\n    stamp: {time: s}" in proposal
    assert "#   q.0 to .1" in proposal
    orbident("convert", "log.mat", "--map", "map.yaml", "-o", "r.csv").refused(
        ": topics[0].take: this key is missing"
    )


def test_a_preset_is_shown_and_used(orbident: Orbident, flight: Recording):
    structs = as_structs(flight)["base"]
    message = {
        "times": (flight.t * 1e9).astype(np.uint64),
        "sigma_BN": np.zeros((flight.t.size, 3)),
        "omega_BN_B": structs["w"],
        "r_BN_N": structs["p"],
        "v_BN_N": structs["w"],
    }
    path = write_log("npz", Path(), {"scStateOutMsg": message})
    orbident("topics", path, "--preset", "basilisk", "-o", "map.yaml").done()
    assert "sigma_BN" in Path("map.yaml").read_text()
    ran = orbident("convert", path, "--preset", "basilisk", "-o", "r.csv")
    assert ran.status == 0
    assert "'/rwSpeedOutMsg'" in ran.err
    orbident("convert", path, "--preset", "basilik", "-o", "r.csv").refused(
        "--preset 'basilik': there is no such map; did you mean 'basilisk'?"
    )
    orbident("convert", path, "-o", "r.csv").refused("give either '--map MAP'")
    orbident(
        "convert", path, "--map", "m", "--preset", "basilisk", "-o", "r.csv"
    ).refused("give either '--map MAP'")
