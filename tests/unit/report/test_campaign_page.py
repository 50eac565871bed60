from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from small_campaigns import begun

from orbident.campaigns.folder import FAILED, Campaign, schema_of
from orbident.files.replacing import write_text
from orbident.report.campaign_page import campaign_report

N = 60


def made_up(campaign: Campaign, scale: float) -> pa.Table:
    """Errors so many times as large as results say; every tenth result refused."""
    random, schema = np.random.default_rng(0), schema_of(campaign)
    refused = np.arange(N) % 10 == 0
    columns = {
        "run": np.arange(N),
        "robot": np.full(N, "paper-spatial"),
        "method": np.full(N, "least-squares"),
        "level": np.where(refused, "do not trust", "trust"),
        "refused_by": ["kinetic energy" if each else None for each in refused],
    }
    for name in schema.names:
        if name.endswith(".value"):
            z = scale * random.standard_normal(N)
            columns[name] = np.where(refused, np.nan, 1.0 + z)
        elif name not in columns:
            columns[name] = (
                random.standard_normal(N) if name.startswith("draw.") else np.ones(N)
            )
    return pa.Table.from_arrays(
        [pa.array(columns[f.name], f.type, from_pandas=True) for f in schema],
        schema=schema,
    )


@pytest.mark.parametrize(
    ("scale", "headline"), [(1.0, "Trusted<"), (2.0, "With care<")]
)
def test_the_report(tmp_path: Path, scale: float, headline: str):
    campaign, out = begun(tmp_path, runs=N + 1)
    (out / FAILED).mkdir()
    write_text(out / FAILED / "60.json", '{"run": 60, "reason": "turns too fast"}')
    text = campaign_report(campaign, out, made_up(campaign, scale))
    assert headline in text
    for words in (
        "60 of 61 runs made, 1 failed",
        "paper-spatial, least squares",
        "60 results, 6 of them refused",
        f"orbident campaign rerun {out} ",
        "kinetic energy",
        "turns too fast",
        "rank correlation",
        "sigma_1: normal plot",
    ):
        assert words in text, words
