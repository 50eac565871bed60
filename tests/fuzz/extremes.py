"""Inputs that are valid or nearly so, and far too large."""

import gzip
import io
from collections.abc import Iterator

import pyarrow as pa
import pyarrow.parquet as pq
from case import Case
from seeds import Seeds

DEEP = 100_000
MANY = 1_000_000
LINKS = 2_000
CHAIN = 60
"""Joints one after the other, as many as a user may wait for."""


def extremes(seeds: Seeds) -> Iterator[Case]:
    """Bombs, nesting, and robots and tables of absurd size."""
    for name, content in _robots():
        yield _case(name, ("inspect", name), {name: content})
    for name, content in _recordings(seeds.csv["paper-spatial"]):
        files = {name: content}
        yield _case(name, ("identify", "paper-spatial", name), files)
        yield _case(name, ("weigh", "paper-spatial", name), files)
    for name, content in _documents():
        yield _case(
            name, ("sample", name, "-o", "s.csv", "--rate", "1"), {name: content}
        )
        yield _case(name, ("inspect", name), {name: content})
        bag = {"map.yaml": content, **seeds.bags["ros1"]}
        to = ("--map", "map.yaml", "-o", "r.csv")
        yield _case(name, ("convert", "bag.bag", *to), bag)
        yield _case(name, ("report", "run"), {**seeds.run, "run/result.json": content})
    yield from _motions(seeds)


def _case(name: str, arguments: tuple[str, ...], files: dict[str, bytes]) -> Case:
    return Case("extremes", arguments, files)


def _robots() -> Iterator[tuple[str, bytes]]:
    yield "chain.urdf", _urdf(CHAIN, lambda k: k)
    yield "long.urdf", _urdf(LINKS, lambda k: k)
    yield "star.urdf", _urdf(LINKS, lambda k: 0)
    yield "binary.urdf", _urdf(LINKS, lambda k: (k + 1) // 2)
    yield "deep.urdf", b"<robot>" + b"<link>" * DEEP
    yield (
        "closed.urdf",
        b"<robot name='r'>" + b"<a>" * DEEP + b"</a>" * DEEP + b"</robot>",
    )
    entities = "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 20))
    yield (
        "laughs.urdf",
        f'<!DOCTYPE r [<!ENTITY a0 "ha">{entities}]><robot>&a19;</robot>'.encode(),
    )
    yield "names.urdf", b"<robot name='" + b"x" * 10_000_000 + b"'/>"


def _urdf(count: int, parent) -> bytes:
    link = (
        "<link name='l{}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' "
        "ixy='0' ixz='0' iyz='0'/></inertial></link>"
    )
    joint = (
        "<joint name='j{0}' type='revolute'><parent link='l{1}'/><child link='l{0}'/>"
        "<axis xyz='{2}'/><limit lower='-1' upper='1' velocity='1' effort='1'/>"
        "<origin xyz='0.1 0 0.2'/></joint>"
    )
    axes = ("1 0 0", "0 1 0", "0 0 1")
    links = "".join(link.format(k) for k in range(count + 1))
    joints = "".join(joint.format(k + 1, parent(k), axes[k % 3]) for k in range(count))
    return f"<robot name='r'>{links}{joints}</robot>".encode()


def _recordings(csv: bytes) -> Iterator[tuple[str, bytes]]:
    header, *rows = csv.splitlines()
    yield "columns.csv", b",".join(b"c%d" % k for k in range(MANY)) + b"\n"
    wide = b",".join(b"c%d" % k for k in range(MANY // 10)) + b"\n"
    yield "wide.csv", b"t," + wide + b"0" * 1 + b",1" * (MANY // 10) + b"\n"
    yield "commas.csv", header + b"\n" + b"," * 20_000_000 + b"\n"
    yield "cell.csv", header + b"\n" + b"1" * 20_000_000 + rows[0] + b"\n"
    yield "quote.csv", header + b'\n"' + b"x\n" * 5_000_000
    yield "empty_lines.csv", header + b"\n" * 20_000_000
    yield "zeros.csv", bytes(20_000_000)
    yield "packed.csv", gzip.compress(bytes(200_000_000))
    yield "packed.csv.gz", gzip.compress(csv)
    yield "packed.parquet", gzip.compress(csv)
    yield "bomb.parquet", _parquet({"t": pa.array([0.0] * 50_000_000)})
    text = pa.array(["x" * 100_000_000])
    yield "text.parquet", _parquet({"t": pa.array([0.0]), "a": text})
    wide_table = {f"c{k}": pa.array([0.0]) for k in range(5_000)}
    yield "wide.parquet", _parquet({"t": pa.array([0.0]), **wide_table})
    nested = pa.array([0.0])
    for _ in range(60):
        nested = pa.StructArray.from_arrays([nested], ["a"])
    yield "nested.parquet", _parquet({"t": pa.array([0.0]), "a": nested})


def _parquet(columns: dict[str, pa.Array]) -> bytes:
    written = io.BytesIO()
    pq.write_table(pa.table(columns), written, compression="zstd")
    return written.getvalue()


def _documents() -> Iterator[tuple[str, bytes]]:
    yield "lists.yaml", b"[" * DEEP
    yield "closed_lists.yaml", b"[" * DEEP + b"]" * DEEP
    yield "maps.yaml", b"{a: " * DEEP
    yield "blocks.yaml", b"- " * DEEP
    yield "indents.yaml", b"".join(b" " * k + b"a:\n" for k in range(2_000))
    levels = "".join(f"a{k}: &a{k} [{f'*a{k - 1},' * 9}]\n" for k in range(1, 12))
    yield "laughs.yaml", f"a0: &a0 x\n{levels}".encode()
    yield "itself.yaml", b"a: &a [*a]\nb: *a\n"
    yield "long.yaml", b"schema: " + b"x" * 10_000_000
    yield "keys.yaml", b"".join(b"k%d: 1\n" % k for k in range(50_000))
    yield "number.yaml", b"duration: " + b"9" * 100_000
    yield "json.yaml", b'{"a":' * 5_000 + b"1" + b"}" * 5_000


def _motions(seeds: Seeds) -> Iterator[Case]:
    motion = seeds.trajectories["cepheus-like"]
    long = motion.replace(b"duration: 12.0", b"duration: 1e9")
    harmonics = b"[" + b"0.001," * 20_000 + b"0.001]"
    many = motion.replace(b"[0.2, -0.1, 0.05]", harmonics)
    many = many.replace(b"[0.1, 0.1, -0.08]", harmonics)
    for content in (long, many):
        for rate in ("10", "1e9", "1e300"):
            files, to = {"m.yaml": content}, ("-o", "s.csv", "--rate", rate)
            yield _case("m", ("sample", "m.yaml", *to), files)
            yield _case("m", ("simulate", "cepheus-like", "m.yaml", *to), files)
