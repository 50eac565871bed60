"""RUN folders that were edited, and whose checksums were made anew."""

import json
import tempfile
from pathlib import Path
from random import Random

import mutations
from case import Case
from mutations import spoiled
from seeds import Seeds

from orbident.identified.run_folder import FILES, OWN, READ, with_checksums

RESULT = "run/result.json"
VERBS = (
    ("validate", "run", "r.csv"),
    ("report", "run", "--force"),
    ("export", "run", "-o", "e.json", "--q", "0,0,0"),
    *(("export", "run", "-o", f"e.{kind}") for kind in ("urdf", "xml", "sdf", "py")),
    *(("export", "run", "-o", f"e.{kind}") for kind in ("mat", "mcap", "tex", "csv")),
    ("export", "run", "--flight", "e"),
    ("compare", "run", "run", "--json", "-"),
    ("view", "run", "--port", "0"),
)


def sealed_runs(random: Random, seeds: Seeds) -> Case:
    """Checksums hold, and the content is as nobody computed it."""
    files = dict(seeds.run)
    spoilt = random.choice([RESULT] * 2 + ["run/signals.parquet"] * 2 + list(files))
    ways = {
        "json": (mutations.in_json,),
        "yaml": mutations.YAML,
        "parquet": (mutations.in_parquet,),
    }.get(spoilt.rpartition(".")[2], mutations.TEXT)
    files[spoilt] = spoiled(random, files[spoilt], ways)
    files = _sealed(files) | {"r.csv": seeds.csv["paper-spatial"]}
    return Case("sealed runs", random.choice(VERBS), files)


def _sealed(files: dict[str, bytes]) -> dict[str, bytes]:
    """The same, where the result is still a JSON object."""
    try:
        document = json.loads(files[RESULT])
        bare = {k: v for k, v in document.items() if k not in {FILES, OWN}}
    except (ValueError, AttributeError):
        return files
    with tempfile.TemporaryDirectory() as place:
        Case("seeds", (), files).write(Path(place))
        whole = with_checksums(bare, Path(place) / "run", READ)
    return files | {RESULT: json.dumps(whole).encode()}
