"""The command as a user meets it: start-up, and a study."""

import subprocess
import sys
from pathlib import Path

import pytest

HELP_SECONDS = 0.5
STUDY_SECONDS = 6
COMMAND = str(Path(sys.executable).with_name("orbident"))


def run(*arguments: str) -> str:
    done = subprocess.run(
        [COMMAND, *arguments], check=True, capture_output=True, text=True
    )
    return done.stdout


@pytest.mark.benchmark(group="command")
def bench_help(benchmark, record, meets):
    said = benchmark.pedantic(run, args=("--help",), rounds=9, warmup_rounds=1)
    assert "identify" in said
    meets(record("help") < HELP_SECONDS)


@pytest.mark.benchmark(group="command")
def bench_study(benchmark, record, meets):
    words = ("study", "spatial", "--noise", "none")
    said = benchmark.pedantic(run, args=words, rounds=3, warmup_rounds=1)
    assert "every parameter recovered" in said
    meets(record("study") < STUDY_SECONDS)
