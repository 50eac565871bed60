"""`orbident robots`."""

import orbident as oi
from orbident.cli.output import Output
from orbident.data_table import table_of


def robots(output: Output) -> None:
    """List the robots that come with Orbident.

    Each name can be given wherever a command takes ROBOT.
    """
    entries = []
    for name in oi.bundled_robots():
        robot = oi.load_robot(name)
        entry = {
            "name": name,
            "motion": robot.motion,
            "joints": len(robot.joints),
            "wheels": len(robot.wheels),
            "mass": robot.mass,
        }
        entries.append(entry)
    output.say(
        f"{len(entries)} robots come with Orbident; each name can be given as ROBOT",
        table_of(
            "",
            ("name", "motion", "joints", "wheels", "mass (kg)"),
            (
                (*map(str, words), f"{mass:.6g}")
                for *words, mass in map(dict.values, entries)
            ),
        ),
    )
    output.write_json({"robots": entries})
