"""The command as a user meets it: start-up, the first study and the next."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HELP_SECONDS = 0.5
FIRST_SECONDS = 25
NEXT_SECONDS = 6
COMMAND = str(Path(sys.executable).with_name("orbident"))


@pytest.fixture
def run(tmp_path):
    """Run the command with a cache folder of its own."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}

    def run(*arguments: str) -> str:
        done = subprocess.run(
            [COMMAND, *arguments],
            env=environment,
            check=True,
            capture_output=True,
            text=True,
        )
        return done.stdout

    return run


@pytest.mark.benchmark(group="command")
def bench_help(benchmark, record, run):
    said = benchmark.pedantic(run, args=("--help",), rounds=9, warmup_rounds=1)
    assert "identify" in said
    assert record("help") < HELP_SECONDS


STUDY = ("study", "spatial", "--noise", "none")


@pytest.mark.benchmark(group="command")
def bench_first_study(benchmark, record, run, tmp_path):
    def forget():
        shutil.rmtree(tmp_path / "cache", ignore_errors=True)

    said = benchmark.pedantic(run, args=STUDY, setup=forget, rounds=3)
    assert "every parameter recovered" in said
    assert record("first study") < FIRST_SECONDS


@pytest.mark.benchmark(group="command")
def bench_next_study(benchmark, record, run):
    said = benchmark.pedantic(run, args=STUDY, rounds=3, warmup_rounds=1)
    assert "every parameter recovered" in said
    assert record("next study") < NEXT_SECONDS
