"""`orbident robots`."""

from orbident.cli.options import Json, Quiet


def robots(json: Json = None, quiet: Quiet = False) -> None:
    """List the robots that come with Orbident.

    Each name can be given wherever a command takes ROBOT.
    """
    from orbident.cli.output import Output
    from orbident.data_table import table_of
    from orbident.robot.robot_file import bundled_robots, load_robot

    output = Output(json, quiet)
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
