"""Folders of campaigns that somebody has edited, and specs that nobody should write."""

import io
import json
from random import Random
from typing import Any

import mutations
import oddities
import pyarrow as pa
import pyarrow.parquet as pq
from case import Case
from mutations import spoiled
from seeds import Seeds

MANIFEST = "out/campaign.json"
NAMES = ("../r.csv", "/dev/zero", "/etc/passwd", "rows", "", "x\0y", "a" * 300, ".")


def campaigns(random: Random, seeds: Seeds) -> Case:
    """A folder or a spec that is spoiled, for each of the verb's commands."""
    files = dict(seeds.campaign)
    spoilt = random.choice(
        ("campaign.yaml", MANIFEST, "rows", "rows", random.choice(list(files)))
    )
    if spoilt == "rows":
        rows = [name for name in files if name.startswith("out/rows/")]
        spoilt = random.choice(rows)
        files[spoilt] = spoiled(random, files[spoilt], ROWS)
    elif spoilt == MANIFEST:
        files[spoilt] = spoiled(random, files[spoilt], (_manifest, *mutations.JSON))
    else:
        yaml = spoilt.endswith("yaml")
        ways = mutations.YAML if yaml else mutations.TEXT
        files[spoilt] = spoiled(random, files[spoilt], ways)
    if random.random() < 0.2:
        # What is missing is made anew.
        del files[random.choice(list(files))]
    if random.random() < 0.2 and spoilt == "campaign.yaml":
        files = {name: c for name, c in files.items() if not name.startswith("out/")}
    arguments = random.choice(
        (
            ["status", "out"],
            ["rerun", "out", random.choice(("0", "2"))],
            ["run", "campaign.yaml", "-o", "out", "--workers", "1"],
        )
    )
    arguments += random.choice(([], ["--json", "-"], ["--quiet"]))
    return Case("campaigns", ("campaign", *arguments), files)


def _manifest(random: Random, content: bytes) -> bytes:
    """Other files are vouched for, or none."""
    document = json.loads(content)
    sums: dict[str, Any] = document["sha256"]
    how = random.randrange(4)
    if how == 0:
        document["sha256"] = {}
    elif how == 1:
        del sums[random.choice(list(sums))]
    elif how == 2:
        sums[random.choice(NAMES)] = random.choice(list(sums.values()))
    else:
        document["versions"] = random.choice(({}, {"numpy": None}, {"x": []}))
    return json.dumps(document).encode()


def _retyped(random: Random, content: bytes) -> bytes:
    """Columns of the rows have other types, or other numbers."""
    table = pq.read_table(io.BytesIO(content))
    for name in random.sample(table.column_names, random.choice((1, 3))):
        k = table.column_names.index(name)
        column: Any = table[name]
        to = random.choice((*TYPES, "value"))
        if to == "value":
            value = oddities.number(random)
            column = pa.array([value] * table.num_rows)
        elif to == "list":
            column = pa.array([[x] for x in column.to_pylist()])
        else:
            column = column.cast(to, safe=False)
        table = table.set_column(k, name, column)
    how = random.random()
    if how < 0.2:
        table = table.drop_columns(random.choice(table.column_names))
    elif how < 0.4:
        table = pa.concat_tables([table, table])
    elif how < 0.5:
        table = table.slice(0, 0)
    written = io.BytesIO()
    pq.write_table(table, written)
    return written.getvalue()


TYPES = ("string", "float32", "int64", "double", "binary", "list", "bool")
ROWS = (_retyped,) * 6 + mutations.BINARY
