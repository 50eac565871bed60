from pathlib import Path

import pytest
from small_campaigns import begun

from orbident.campaigns.conduct import repeat_run
from orbident.campaigns.folder import path_of
from orbident.errors import InputError


def test_rows_that_cannot_be_read_leave_no_rerun(tmp_path: Path):
    campaign, folder = begun(tmp_path / "c")
    path = path_of(folder, campaign.spec.chunks[0])
    path.parent.mkdir()
    path.write_bytes(b"cut")
    with pytest.raises(InputError, match="cannot be read"):
        repeat_run(campaign, folder, 0)
    assert not (folder / "rerun").exists()
