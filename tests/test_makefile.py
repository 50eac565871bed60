"""What `make` says on a machine that lacks something."""

import shutil
from pathlib import Path

from processes import finished

ROOT = Path(__file__).parents[1]


def test_a_missing_compiler_is_named_before_anything_is_installed(tmp_path: Path):
    for file in ("Makefile", "pyproject.toml", "CMakeLists.txt"):
        shutil.copy(ROOT / file, tmp_path)
    (tmp_path / "src" / "core").mkdir(parents=True)
    tools = tmp_path / "tools"
    tools.mkdir()
    for tool in ("sh", "find"):
        (tools / tool).symlink_to(str(shutil.which(tool)))
    make = str(shutil.which("make"))
    ran = finished(make, "demo", cwd=tmp_path, env={"PATH": str(tools)})
    assert ran.returncode != 0
    assert ran.stdout == (
        "orbident needs a C++17 compiler (g++ or clang++): install one, "
        "then make again\n"
    )
    assert not (tmp_path / ".venv").exists()
