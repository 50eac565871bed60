"""Names that a user gave stay names in the files of parameters."""

from dataclasses import replace

import pytest
import report_runs

from orbident.identified.parameter_files import parameters_as_latex


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
def test_a_name_with_a_line_end_stays_in_the_comment(end: str):
    result = report_runs.result()
    robot = replace(result.robot, name=f"r{end}\\input{{secret.txt}}{end}%")
    lines = parameters_as_latex(replace(result, robot=robot)).splitlines()
    assert lines[:2] == [
        f"% r \\input{{secret.txt}} %, {result.method}",
        r"\begin{tabular}{lrrrl}",
    ]
