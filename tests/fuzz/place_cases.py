"""Places that are no files: FIFOs, devices, a working directory that is gone."""

from random import Random

from case import CLOSED, DELETED, FIFO, STDIN, Case
from seeds import MAP, Seeds

DEVICES = ("/dev/null", "/dev/zero", "/dev/full", "/proc/self/mem", "/dev/fd/99", "/")


def places(random: Random, seeds: Seeds) -> Case:
    """A verb that works, where one of its files is such a place."""
    files = {
        **seeds.run,
        **seeds.robots["paper-spatial"],
        **seeds.campaign,
        "r.csv": seeds.csv["paper-spatial"],
        "m.yaml": seeds.trajectories["paper-spatial"],
        "log.csv": seeds.logs["csv"][1],
        "map.yaml": MAP.encode(),
        "bag.bag": seeds.bags["ros1"]["bag.bag"],
        STDIN: seeds.stream,
        **seeds.models,
    }
    arguments = list(random.choice(VERBS))
    setting = random.choice(("",) * 6 + (CLOSED, DELETED))
    k = random.choice([k for k, word in enumerate(arguments) if k and word in files])
    how = random.choice(("fifo", "stdin", "device", "folder", "name", "output"))
    suffix = arguments[k].rpartition(".")[2]
    if how == "fifo":
        fifo = f"{FIFO}.{suffix}"
        files[fifo] = random.choice((files[arguments[k]], b""))
        arguments[k] = fifo
    elif how == "stdin":
        files[STDIN] = files[arguments[k]]
        arguments[k] = random.choice(("/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"))
    elif how == "device":
        arguments[k] = random.choice(DEVICES)
    elif how == "folder":
        arguments[k] = "run"
    elif how == "name":
        name = random.choice(NAMES).format(suffix)
        files[name] = files[arguments[k]]
        arguments[k] = name
    elif "-o" in arguments:
        # A FIFO that nobody reads makes every program wait that writes to it.
        outputs = (*DEVICES, "run", "no/where.csv", "/dev/stdout")
        arguments[-1] = random.choice(outputs)
        arguments += random.choice(([], ["--force"]))
    return Case("places", tuple(arguments), files, setting)


NAMES = (
    "\udcff.{0}",
    "a\nb.{0}",
    "-x.{0}",
    "x" * 240 + ".{0}",
    " .{0}",
    "\N{BELL}.{0}",
)
VERBS = (
    ("check", "paper-spatial.yaml"),
    ("inspect", "robot.xml"),
    ("inspect", "robot.xacro"),
    ("identify", "paper-spatial.yaml", "r.csv", "--method", "least-squares"),
    ("weigh", "paper-spatial", "r.csv"),
    ("noise", "r.csv", "-o", "sensors.yaml"),
    ("validate", "run", "r.csv"),
    ("simulate", "paper-spatial", "m.yaml", "--rate", "2", "-o", "s.csv"),
    ("sample", "m.yaml", "--rate", "2", "-o", "s.csv"),
    ("topics", "log.csv", "-o", "proposed.yaml"),
    ("convert", "bag.bag", "--map", "map.yaml", "-o", "s.csv"),
    ("campaign", "run", "campaign.yaml", "--workers", "1", "-o", "out"),
    ("live", "paper-spatial.yaml", "--state", "map.yaml"),
    ("view", "paper-spatial", "--port", "0", "--recording", "r.csv"),
)
"""What follows `-o` stands last."""
