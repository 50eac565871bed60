"""One rule for every verb that writes: what is there stays, unless --force is given."""

from pathlib import Path

import pytest
import typer
from running import LINEAR, Orbident, written
from typer.core import TyperGroup

from orbident.cli.verbs import app
from orbident.recordings.recording import Recording

WRITING = {
    "topics": ("topics", "gone.mcap", "-o", "there.yaml"),
    "convert": ("convert", "gone.mcap", "--preset", "cepheus", "-o", "there.csv"),
    "excite": ("excite", "gone.yaml", "-o", "there.yaml"),
    "sample": ("sample", "gone.yaml", "--rate", "5", "-o", "there.csv"),
    "simulate": ("simulate", "gone.yaml", "gone.yaml", "-o", "there.csv"),
    "noise": ("noise", "gone.csv", "-o", "there.yaml"),
    "noise --plot": ("noise", "gone.csv", "--plot", "there.html"),
    "export": ("export", "gone", "-o", "there.urdf"),
}
"""Verbs that write a file, with inputs that are not there."""


@pytest.mark.parametrize("verb", WRITING)
def test_a_file_that_is_there_stays(orbident: Orbident, verb: str):
    """It is refused before any input is looked at."""
    place = Path(WRITING[verb][-1])
    place.write_text("mine")
    said = orbident(*WRITING[verb]).refused(f"{place}: exists already", "--force")
    assert "gone" not in said
    assert "gone" in orbident(*WRITING[verb], "--force").refused()
    assert place.read_text() == "mine"
    # There is nothing to lose in an empty file, such as `mktemp` makes.
    place.write_text("")
    assert "gone" in orbident(*WRITING[verb]).refused()


def test_force_replaces_it(orbident: Orbident, flight: Recording):
    written(flight, "r.csv", rows=slice(40))
    orbident("identify", "paper-spatial", "r.csv", *LINEAR, "-o", "run").done()
    Path("x.csv").write_text("mine")
    orbident("export", "run", "-o", "x.csv", "--force").done()
    assert "M" in Path("x.csv").read_text()


def test_every_verb_that_writes_has_force():
    group = typer.main.get_command(app)
    # A campaign is gone on with, and what it has made already stays.
    assert isinstance(group, TyperGroup)
    for name, verb in group.commands.items():
        options = {flag for each in verb.params for flag in each.opts}
        if options & {"-o", "--plot", "--flight"}:
            assert "--force" in options, name
