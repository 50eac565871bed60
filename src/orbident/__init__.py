"""Identification of free-flying space manipulators.

```python
import orbident as oi

robot = oi.load_robot("servicer.yaml")
recording = oi.simulate(robot, oi.load_trajectory("excite.yaml"))
result = oi.identify(robot, recording)
oi.validate(result, oi.read_recording("other.csv"))
```
"""

import importlib
from typing import TYPE_CHECKING, Any

from orbident.extras import provide

if TYPE_CHECKING:
    from orbident.errors import InputError as InputError
    from orbident.estimation.identify import identify as identify
    from orbident.estimation.least_squares import LeastSquares as LeastSquares
    from orbident.estimation.least_squares import Structured as Structured
    from orbident.estimation.output_error.estimator import OutputError as OutputError
    from orbident.estimation.recursive.history import Recursive as Recursive
    from orbident.estimation.result import Result as Result
    from orbident.estimation.weigh import Weighing as Weighing
    from orbident.estimation.weigh import weigh as weigh
    from orbident.excitation.design import design_excitation as design_excitation
    from orbident.identified.comparison import Comparison as Comparison
    from orbident.identified.comparison import compare as compare
    from orbident.identified.run_folder import load_result as load_result
    from orbident.identified.run_folder import save_result as save_result
    from orbident.identified.validate import Validation as Validation
    from orbident.identified.validate import validate as validate
    from orbident.model.minimal_sets import MinimalSets as MinimalSets
    from orbident.model.minimal_sets import minimal_sets as minimal_sets
    from orbident.model.reconstruction import Dynamics as Dynamics
    from orbident.recordings.recording import Recording as Recording
    from orbident.recordings.tables import read_recording as read_recording
    from orbident.recordings.tables import write_recording as write_recording
    from orbident.recordings.topics.convert import ConversionReport as ConversionReport
    from orbident.recordings.topics.convert import convert_file as convert_file
    from orbident.recordings.topics.survey import Surveyed as Surveyed
    from orbident.recordings.topics.survey import survey_file as survey_file
    from orbident.robot.description import Robot as Robot
    from orbident.robot.robot_file import bundled_robots as bundled_robots
    from orbident.robot.robot_file import load_robot as load_robot
    from orbident.simulation.simulate import simulate as simulate
    from orbident.trajectories.environment import Environment as Environment
    from orbident.trajectories.trajectory import InitialState as InitialState
    from orbident.trajectories.trajectory import Trajectory as Trajectory
    from orbident.trajectories.trajectory_file import load_trajectory as load_trajectory
    from orbident.trajectories.trajectory_file import save_trajectory as save_trajectory

_PUBLIC = {
    "Comparison": "orbident.identified.comparison",
    "ConversionReport": "orbident.recordings.topics.convert",
    "Dynamics": "orbident.model.reconstruction",
    "Environment": "orbident.trajectories.environment",
    "InitialState": "orbident.trajectories.trajectory",
    "InputError": "orbident.errors",
    "LeastSquares": "orbident.estimation.least_squares",
    "MinimalSets": "orbident.model.minimal_sets",
    "OutputError": "orbident.estimation.output_error.estimator",
    "Recording": "orbident.recordings.recording",
    "Recursive": "orbident.estimation.recursive.history",
    "Result": "orbident.estimation.result",
    "Robot": "orbident.robot.description",
    "Structured": "orbident.estimation.least_squares",
    "Surveyed": "orbident.recordings.topics.survey",
    "Trajectory": "orbident.trajectories.trajectory",
    "Validation": "orbident.identified.validate",
    "Weighing": "orbident.estimation.weigh",
    "bundled_robots": "orbident.robot.robot_file",
    "compare": "orbident.identified.comparison",
    "convert_file": "orbident.recordings.topics.convert",
    "design_excitation": "orbident.excitation.design",
    "identify": "orbident.estimation.identify",
    "load_result": "orbident.identified.run_folder",
    "load_robot": "orbident.robot.robot_file",
    "load_trajectory": "orbident.trajectories.trajectory_file",
    "minimal_sets": "orbident.model.minimal_sets",
    "read_recording": "orbident.recordings.tables",
    "save_result": "orbident.identified.run_folder",
    "save_trajectory": "orbident.trajectories.trajectory_file",
    "simulate": "orbident.simulation.simulate",
    "survey_file": "orbident.recordings.topics.survey",
    "validate": "orbident.identified.validate",
    "weigh": "orbident.estimation.weigh",
    "write_recording": "orbident.recordings.tables",
}

provide("causes", "orbident.diagnosis.causes:causes")
provide("html", "orbident.report.parameter_section:first_table")
provide("nearest_dynamics", "orbident.identified.physical:nearest_dynamics")
provide("plain_change", "orbident.diagnosis.events:plain_change")
provide("plain_mistake", "orbident.diagnosis.linear_test:plain_mistake")
provide("plot", "orbident.report.drawing:Plots")
provide("to_mujoco", "orbident.identified.simulator_models:mujoco_spec")
provide("to_pinocchio", "orbident.identified.simulator_models:pinocchio_model")


def __getattr__(name: str) -> Any:
    # Late, so that importing orbident costs nothing.
    if name == "__version__":
        from importlib.metadata import version

        return version("orbident")
    if name not in _PUBLIC:
        raise AttributeError(f"module 'orbident' has no attribute '{name}'")
    return getattr(importlib.import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return sorted(_PUBLIC)
