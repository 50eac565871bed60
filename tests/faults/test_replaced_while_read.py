"""A reader that a writer overtakes twice."""

from pathlib import Path

import pytest
from crash_points import NEW, OLD, save

from orbident.identified import run_folder


def test_the_same_result_in_new_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Its text is what was read before, although all was replaced meanwhile."""
    folder = tmp_path / "run"
    save(OLD, folder)
    check_files, overtaken = run_folder.check_files, []

    def check(*arguments) -> None:
        if not overtaken:
            overtaken.append(True)
            save(NEW, folder)
            try:
                check_files(*arguments)
            finally:
                save(OLD, folder)
        check_files(*arguments)

    monkeypatch.setattr(run_folder, "check_files", check)
    assert run_folder.load_result(folder).mass.value == 1.0
