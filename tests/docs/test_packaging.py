"""What installs Orbident in other ways says the same as `pyproject.toml`."""

import json
import tomllib

import yaml
from pages import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def test_the_recipe_of_conda():
    recipe = yaml.safe_load((ROOT / "conda/meta.yaml").read_text())
    project, needs = PROJECT["project"], recipe["requirements"]
    assert recipe["package"] == {k: project[k] for k in ("name", "version")}
    python = f"python {project['requires-python']}"
    assert needs["run"] == [python, *project["dependencies"]]
    # Eigen alone has another name there.
    built = [
        each.removeprefix("cmeel-") for each in PROJECT["build-system"]["requires"]
    ]
    assert {python, *built} <= {*needs["host"]}
    scripts = [f"{name} = {where}" for name, where in project["scripts"].items()]
    assert recipe["build"]["entry_points"] == scripts
    assert recipe["about"]["license"] == project["license"]


def test_the_container():
    folder = ROOT / ".devcontainer"
    document = json.loads((folder / "devcontainer.json").read_text())
    image = (folder / document["build"]["dockerfile"]).read_text().split()[1]
    oldest = PROJECT["project"]["requires-python"].removeprefix(">=")
    assert image == f"python:{oldest}"
    assert document["postCreateCommand"] == "make demo"


def test_public_ci_has_every_python_and_system():
    jobs = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text())["jobs"]
    install, wheels = (
        jobs[name]["strategy"]["matrix"] for name in ("install", "wheels")
    )
    said = [c.split(" :: ")[-1] for c in PROJECT["project"]["classifiers"]]
    assert install["python"] == [c for c in said if c.startswith("3.")]
    assert install["os"] == wheels["os"]
    assert len(install["os"]) == sum(
        c.startswith("Operating System") for c in PROJECT["project"]["classifiers"]
    )
