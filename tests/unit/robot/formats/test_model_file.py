import os
from pathlib import Path
from threading import Thread

import pytest

from orbident.errors import InputError
from orbident.robot.formats.model_file import read_model


@pytest.mark.parametrize(
    ("name", "content"), [("r.xacro", "<robot/>"), ("r.xml", "<mujoco/>")]
)
def test_a_pipe_is_refused_where_it_is_read_twice(
    tmp_path: Path, name: str, content: str
):
    """The second time nobody would write to it, and the reader would wait for ever."""
    path = tmp_path / name
    os.mkfifo(path)
    Thread(target=path.write_text, args=(content,), daemon=True).start()
    with pytest.raises(InputError, match="is a pipe"):
        read_model(path)
