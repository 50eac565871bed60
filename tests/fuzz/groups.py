"""Groups of cases: what is spoiled, and which verb is given it."""

from collections.abc import Callable, Mapping
from random import Random

import mutations
import oddities
from archive_cases import archives
from campaign_cases import campaigns
from case import STDIN, Case
from live_cases import live
from model_cases import added_models
from mutations import spoiled
from place_cases import places
from sealed_run_cases import sealed_runs
from seeds import LOG_MAP, MAP, Seeds
from table_cases import tables

METHODS = ("least-squares", "structured", "maximum-likelihood", "recursive")
SMALL = ("paper-spatial", "cepheus-like")
NAMES = (*SMALL, "dual-arm")

Group = Callable[[Random, Seeds], Case]


def identify(random: Random, seeds: Seeds) -> Case:
    """A spoiled recording of a bundled robot, by one of the methods."""
    # The one with two arms takes ten times as long.
    name = random.choice((*SMALL * 8, "dual-arm"))
    recording, content = _recording(random, seeds, name)
    method = random.choice(METHODS)
    momentum = random.choice(("unknown", "at-rest", "first-sample"))
    arguments = ["identify", name, recording, "--method", method]
    arguments += ["--initial-momentum", momentum]
    arguments += random.choice((["-o", "run"], ["--json", "-"], ["--quiet"], []))
    if random.random() < 0.05:
        arguments += ["--burn", recording]
    return Case("identify", tuple(arguments), {recording: content})


def robot_urdf(random: Random, seeds: Seeds) -> Case:
    """A spoiled URDF, alone or named by its robot file."""
    name = random.choice(NAMES)
    files = dict(seeds.robots[name])
    urdf = f"{name}.urdf"
    files[urdf] = spoiled(random, files[urdf], mutations.TEXT)
    return _of_robot(random, seeds, name, random.choice((urdf, f"{name}.yaml")), files)


def robot_file(random: Random, seeds: Seeds) -> Case:
    """A spoiled robot file."""
    name = random.choice(NAMES)
    files = dict(seeds.robots[name])
    robot = f"{name}.yaml"
    files[robot] = spoiled(random, files[robot], mutations.YAML)
    return _of_robot(random, seeds, name, robot, files)


def models(random: Random, seeds: Seeds) -> Case:
    """A spoiled MJCF, SDF or xacro file, or bodies or a DH table in a robot file."""
    name = random.choice(list(seeds.models))
    ways = mutations.YAML if name.endswith("yaml") else mutations.TEXT
    content = spoiled(random, seeds.models[name], ways)
    if random.random() < 0.05:
        name = random.choice(list(seeds.models))
    files, robot = {name: content}, name
    if not name.endswith("yaml") and random.random() < 0.2:
        files["of.yaml"] = f"schema: orbident/robot/1\nmodel: {name}\n".encode()
        robot = "of.yaml"
    verb = random.choice(("check", "check", "inspect"))
    shown = random.choice(([], ["--json", "-"], ["--quiet"]))
    return Case("models", (verb, robot, *shown), files)


def _of_robot(
    random: Random, seeds: Seeds, name: str, robot: str, files: Mapping[str, bytes]
) -> Case:
    verb = random.choice(("inspect", "inspect", "weigh", "simulate", "identify"))
    arguments = [verb, robot]
    files = dict(files)
    if verb in {"weigh", "identify"}:
        files["r.csv"] = seeds.csv[name]
        arguments.append("r.csv")
    if verb == "identify":
        arguments += ["--method", "least-squares"]
    if verb == "simulate":
        files["m.yaml"] = seeds.trajectories[name]
        arguments += ["m.yaml", "-o", "s.csv", "--rate", "2"]
        arguments += random.choice(([], ["--noise", "sensors"], ["--truth"]))
    if verb == "inspect" and random.random() < 0.2:
        files["m.yaml"] = seeds.trajectories[name]
        arguments += ["--trajectory", "m.yaml"]
    arguments += random.choice(([], ["--json", "-"], ["--quiet"]))
    return Case("robots", tuple(arguments), files)


def recordings(random: Random, seeds: Seeds) -> Case:
    """A spoiled recording for the verbs that read one."""
    name = "paper-spatial"
    recording, content = _recording(random, seeds, name)
    files = {recording: content}
    arguments = ["weigh", name, recording]
    kind = random.random()
    if kind < 0.4:
        files |= seeds.run
        arguments = ["validate", "run", recording]
    elif kind < 0.6:
        arguments = ["noise", recording, "-o", "sensors.yaml"]
    arguments += random.choice(([], ["--json", "-"], ["--quiet"]))
    return Case("recordings", tuple(arguments), files)


def _recording(random: Random, seeds: Seeds, name: str) -> tuple[str, bytes]:
    if random.random() < 0.3:
        content = spoiled(random, seeds.parquet[name], mutations.PARQUET)
        return random.choice(("r.parquet",) * 9 + ("r.csv",)), content
    content = spoiled(random, seeds.csv[name], mutations.CSV)
    return random.choice(("r.csv",) * 9 + ("r.parquet", "r", "\udcff.csv")), content


def bags(random: Random, seeds: Seeds) -> Case:
    """A spoiled bag, or a whole one with a spoiled map."""
    kind = random.choice(list(seeds.bags))
    files = dict(seeds.bags[kind])
    bag = next(iter(files)).split("/")[0]
    verb = random.choice(("topics", "convert", "convert"))
    if verb == "topics" or random.random() < 0.5:
        spoilt = random.choice(list(files))
        ways = mutations.YAML if spoilt.endswith("yaml") else mutations.BINARY
        files[spoilt] = spoiled(random, files[spoilt], ways)
        if random.random() < 0.1:
            del files[random.choice(list(files))]
        files["map.yaml"] = MAP.encode()
    else:
        files["map.yaml"] = spoiled(random, MAP.encode(), mutations.YAML)
    to = {
        "topics": random.choice(([], ["-o", "proposed.yaml"], ["--json", "-"])),
        "convert": ["--map", "map.yaml", "-o", random.choice(("r.csv", "r.parquet"))],
    }
    return Case("bags", (verb, bag, *to[verb]), files)


def logs(random: Random, seeds: Seeds) -> Case:
    """A spoiled file of another tool, or a whole one with a spoiled map."""
    kind = random.choice(list(seeds.logs))
    suffix, content = seeds.logs[kind]
    flat = kind in {"csv", "parquet"}
    topic_map = (LOG_MAP.replace("/log", "/") if flat else LOG_MAP).encode()
    verb = random.choice(("topics", "convert", "convert"))
    if verb == "topics" or random.random() < 0.6:
        ways = mutations.CSV if kind == "csv" else mutations.BINARY
        content = spoiled(random, content, ways)
    else:
        topic_map = spoiled(random, topic_map, mutations.YAML)
    log = f"log{suffix}" if random.random() < 0.95 else "log.mat"
    to = ["--map", "map.yaml", "-o", "r.csv"] if verb == "convert" else []
    return Case("logs", (verb, log, *to), {log: content, "map.yaml": topic_map})


def trajectories(random: Random, seeds: Seeds) -> Case:
    """A spoiled trajectory."""
    name = random.choice(SMALL)
    content = spoiled(random, seeds.trajectories[name], mutations.YAML)
    rate = random.choice(("1", "2", "10", oddities.number(random)))
    arguments = random.choice(
        (
            ["sample", "m.yaml", "-o", random.choice(("s.csv", "s.parquet"))],
            ["sample", "m.yaml", "-o", "s.yaml", "--format", "joint-trajectory"],
            ["simulate", name, "m.yaml", "-o", "s.csv"],
            ["simulate", name, "m.yaml", "-o", "s.csv", "--noise", "sensors"],
        )
    )
    return Case("trajectories", (*arguments, "--rate", rate), {"m.yaml": content})


def runs(random: Random, seeds: Seeds) -> Case:
    """A spoiled RUN."""
    files = dict(seeds.run)
    spoilt = random.choice(["run/result.json"] * 3 + list(files))
    ways = {
        "json": mutations.JSON,
        "yaml": mutations.YAML,
        "parquet": mutations.PARQUET,
    }.get(spoilt.rpartition(".")[2], mutations.TEXT)
    files[spoilt] = spoiled(random, files[spoilt], ways)
    if random.random() < 0.05:
        del files[random.choice(list(files))]
    files["r.csv"] = seeds.csv["paper-spatial"]
    whole = {name.replace("run/", "whole/"): c for name, c in seeds.run.items()}
    arguments = random.choice(
        (
            ["validate", "run", "r.csv"],
            ["validate", "run", "r.csv", "--json", "-"],
            ["report", "run", "--force"],
            ["export", "run", "-o", "e.json", "--q", "0,0,0"],
            ["export", "run", "-o", random.choice(("e.xml", "e.sdf", "e.py", "e.mat"))],
            ["export", "run", "-o", "e.mcap", "--recording", "r.csv"],
            ["compare", "run", "whole"],
            ["compare", "whole", "run", "--json", "-"],
        )
    )
    if arguments[0] == "compare":
        files |= whole
    return Case("runs", tuple(arguments), files)


def scenes(random: Random, seeds: Seeds) -> Case:
    """What `view` is given: robots with shapes, recordings, RUNs."""
    name = random.choice(SMALL)
    files = dict(seeds.robots[name]) | {"r.csv": seeds.csv[name]}
    how = random.randrange(3)
    shown = f"{name}.yaml"
    if how == 0:
        files["link.stl"] = spoiled(random, _triangle(), mutations.TEXT)
        urdf = files[f"{name}.urdf"].replace(
            b"<cylinder", b'<mesh filename="link.stl"/><cylinder', 1
        )
        files[f"{name}.urdf"] = spoiled(random, urdf, mutations.TEXT)
    elif how == 1:
        files["r.csv"] = spoiled(random, files["r.csv"], mutations.CSV)
    else:
        files |= runs(random, seeds).files
        shown = "run"
    arguments = ["view", shown, "--port", "0"]
    if how == 1 or random.random() < 0.5:
        arguments += ["--recording", "r.csv"]
    return Case("scenes", tuple(arguments), files)


def _triangle() -> bytes:
    return (
        b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
        b"vertex 0 1 0\nendloop\nendfacet\nendsolid s\n"
    )


OPTIONS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "robots": (),
    "inspect": (("paper-spatial",), ("--initial-momentum", "unknown")),
    "check": (("paper-spatial",),),
    "new": (("new.yaml",), ("--joints", "2"), ("--wheels", "1"), ("--dh",)),
    "topics": (("bag.bag",), ("-o", "map.yaml")),
    "convert": (("bag.bag",), ("--map", "map.yaml"), ("-o", "r.csv")),
    "excite": (
        ("cepheus-like",),
        ("-o", "m.yaml"),
        ("--duration", "5"),
        ("--harmonics", "2"),
        ("--starts", "1"),
        ("--budget", "1"),
        ("--seed", "1"),
        ("--limit", "base-rate=0.5"),
    ),
    "sample": (("m.yaml",), ("-o", "s.csv"), ("--rate", "10")),
    "simulate": (
        ("cepheus-like",),
        ("m.yaml",),
        ("-o", "s.csv"),
        ("--rate", "10"),
        ("--noise", "sensors"),
        ("--seed", "1"),
    ),
    "identify": (
        ("cepheus-like",),
        ("r.csv",),
        ("-o", "new"),
        ("--method", "structured"),
    ),
    "report": (("run",), ("--force",)),
    "weigh": (("cepheus-like",), ("r.csv",)),
    "noise": (("r.csv",), ("-o", "sensors.yaml"), ("--plot", "allan.html")),
    "validate": (("run",), ("r.csv",)),
    "compare": (("run",), ("run",), ("--body", "link3")),
    "export": (("run",), ("-o", "e.json"), ("--q", "0,0,0")),
    "view": (("cepheus-like",), ("--port", "0"), ("--recording", "r.csv")),
    "live": (
        ("paper-spatial",),
        ("--every", "1"),
        ("--velocity-std", "1e-3"),
        ("--state", "state"),
    ),
    "campaign": (("status",), ("out",)),
    "doctor": (),
}
"""Arguments with which each verb does its work, each with its value."""

SHARED = (
    ("--json", "-"),
    ("--json", "out.json"),
    ("--quiet",),
    ("--help",),
    ("--force",),
)


def arguments(random: Random, seeds: Seeds) -> Case:
    """Valid files, and a verb with some of its options wrong, missing or twice."""
    verb = random.choice(list(OPTIONS))
    given = [list(each) for each in OPTIONS[verb]]
    given += [list(each) for each in SHARED if random.random() < 0.15]
    for _ in range(random.choice((1, 1, 2))):
        _spoil_arguments(random, given)
    flat = tuple(word for each in given for word in each)
    files = {**seeds.run, **seeds.campaign} | {
        STDIN: seeds.stream,
        "r.csv": seeds.csv["cepheus-like"],
        "m.yaml": seeds.trajectories["cepheus-like"],
        "map.yaml": MAP.encode(),
        "bag.bag": seeds.bags["ros1"]["bag.bag"],
    }
    return Case("arguments", (verb, *flat), files)


def _spoil_arguments(random: Random, given: list[list[str]]) -> None:
    if not given:
        given.append([_argument(random)])
        return
    k = random.randrange(len(given))
    how = random.randrange(6)
    if how == 0:
        del given[k]
    elif how == 1:
        given.append(given[k])
    elif how == 2:
        given.insert(k, [_argument(random)])
    else:
        given[k][-1] = _argument(random)


def _argument(random: Random) -> str:
    made = random.choice(
        (
            oddities.number,
            oddities.word,
            lambda random: random.choice(
                (".", "..", "run", "r.csv", "no/where", "m.yaml")
            ),
            lambda random: random.choice(
                ("--", "-", "-o", "--nonsense", "--jsn", "\udcff")
            ),
        )
    )
    # The system passes neither this character nor very long arguments.
    return made(random).replace("\0", "")


def excitations(random: Random, seeds: Seeds) -> Case:
    """A search of one start, within limits and for times that nobody has."""
    arguments = ["excite", "cepheus-like", "-o", "x.yaml", "--starts", "1"]
    arguments += random.choice(([], ["--like-paper"], ["--like", "m.yaml"]))
    for option in ("--duration", "--harmonics", "--uncertainty"):
        if random.random() < 0.4:
            number = random.choice(("1", "20", "1e-9", oddities.number(random)))
            arguments.append(f"{option}={number}")
    for name in ("acceleration", "base_rate", "excursion", "wheel_speed"):
        if random.random() < 0.3:
            number = random.choice(("0.3", "300", "1e-9", oddities.number(random)))
            arguments.append(f"--limit={name}={number}")
    files = {"m.yaml": seeds.trajectories["cepheus-like"]}
    return Case("excitations", tuple(arguments), files)


GROUPS: Mapping[Group, int] = {
    robot_urdf: 3,
    robot_file: 3,
    models: 3,
    recordings: 3,
    bags: 3,
    logs: 3,
    trajectories: 2,
    runs: 3,
    scenes: 1,
    arguments: 3,
    live: 4,
    campaigns: 2,
    sealed_runs: 2,
    added_models: 4,
    archives: 4,
    tables: 3,
    places: 3,
    excitations: 1,
}
"""What is run beside `identify`, and how often of 50."""
