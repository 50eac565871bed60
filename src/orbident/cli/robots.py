"""`orbident robots`."""

from orbident.cli.options import Json, Quiet


def robots(json: Json = None, quiet: Quiet = False) -> None:
    """List the robots that come with Orbident.

    Each name can be given wherever a command takes ROBOT.
    """
    from rich.table import Table

    from orbident.cli.output import Output
    from orbident.robot.robot_file import bundled_robots, load_robot

    output = Output(json, quiet)
    table = Table("name", "motion", "joints", "wheels", "mass (kg)", box=None)
    entries = []
    for name in bundled_robots():
        robot = load_robot(name)
        entry = {
            "name": name,
            "motion": robot.motion,
            "joints": len(robot.joints),
            "wheels": len(robot.wheels),
            "mass": robot.mass,
        }
        entries.append(entry)
        *words, mass = entry.values()
        table.add_row(*map(str, words), f"{mass:.6g}")
    output.say(
        f"{len(entries)} robots come with Orbident; each name can be given as ROBOT",
        table,
    )
    output.write_json({"robots": entries})
