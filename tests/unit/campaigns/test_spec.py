from pathlib import Path

import numpy as np
import pytest
from small_campaigns import write_campaign

from orbident.campaigns.spec import Distribution, load_spec
from orbident.errors import InputError


def test_distributions_have_units(tmp_path: Path):
    path = write_campaign(
        tmp_path,
        disperse={
            "inertia": {"normal": "10 %"},
            "initial": {"angular_velocity": {"uniform": ["-180 deg/s", 1]}},
        },
    )
    disperse = load_spec(path).spec.disperse
    assert disperse.inertia == Distribution("normal", (0.1,))
    assert disperse.noise is None
    given = disperse.initial.angular_velocity
    assert given == Distribution("uniform", (-np.pi, 1.0))


@pytest.mark.parametrize(
    ("runs", "chunk", "files", "size"),
    [
        (3, None, 1, 3),
        (500, None, 100, 5),
        (2000, None, 200, 10),
        (10**5, None, 1000, 100),
        (2000, 7, 286, 7),
    ],
)
def test_files_are_neither_many_nor_large(
    tmp_path: Path, runs: int, chunk: int | None, files: int, size: int
):
    chunks = load_spec(write_campaign(tmp_path, runs=runs, chunk=chunk)).spec.chunks
    assert (len(chunks), len(chunks[0])) == (files, size)
    assert [k for each in chunks for k in each] == list(range(runs))


def test_what_is_drawn():
    random = np.random.default_rng(0)
    normal = Distribution("normal", (2.0,)).draw(random, 10_000)
    # Four deviations of the mean and of the deviation.
    assert abs(normal.mean()) < 4 * 2 / 100
    assert abs(normal.std() - 2) < 4 * 2 / np.sqrt(2 * 10_000)
    uniform = Distribution("uniform", (1.0, 3.0)).draw(random, 10_000)
    assert 1 <= uniform.min() < 1.01 < 2.99 < uniform.max() <= 3
    signs = Distribution("signs", (0.2,)).draw(random, 10_000)
    assert set(signs) == {0.2, -0.2}
    assert abs(signs.mean()) < 4 * 0.2 / 100


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"disperse": {"inertia": {"gaussian": 1}}}, "unknown distribution 'gaussian'"),
        ({"disperse": {"inertia": {"normal": "1 deg"}}}, "unknown unit 'deg'"),
        ({"disperse": {"inertia": {"normal": -1}}}, "a size of zero or more"),
        ({"disperse": {"noise": 0.1}}, "give one distribution with its numbers"),
        ({"disperse": {"noise": {"uniform": [1, 0]}}}, "with lower below upper"),
        ({"disperse": {"noise": {"uniform": 1}}}, "give uniform: [lower, upper]"),
        ({"disperse": {"noise": {"uniform": [-700, 0]}}}, "numbers of at most 1"),
        ({"disperse": {"inertia": {"normal": "2000 %"}}}, "numbers of at most 1"),
        ({"disperse": {"mass": {"normal": 1}}}, "unknown key 'mass'"),
        ({"methods": ["lsq"]}, "found 'lsq'; give 'maximum-likelihood'"),
        ({"methods": []}, "methods: found none; give one or more"),
        ({"methods": 2 * ["recursive"]}, "'recursive' is given twice"),
        ({"robots": []}, "robots: found none; give one or more"),
        ({"runs": 0}, "runs: found 0"),
        ({"runs": True}, "runs: found True"),
        ({"entropy": -1}, "entropy: found -1"),
        ({"schema": "orbident/robot/1"}, "schema: found 'orbident/robot/1'"),
    ],
)
def test_one_line_says_what_is_wrong(tmp_path: Path, changes, words: str):
    path = write_campaign(tmp_path, **changes)
    with pytest.raises(InputError) as refused:
        load_spec(path)
    assert str(refused.value).startswith(f"{path}:")
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
