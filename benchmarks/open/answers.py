"""What a method says of one recording: parameters and deviations, or a refusal."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Answer:
    """Values and standard deviations by name; what is not determined is absent."""

    values: dict[str, float] = field(default_factory=dict)
    std: dict[str, float] = field(default_factory=dict)
    refused: str = ""
    """Why there are no values."""
    seconds: float = float("nan")

    def vector(self, kind: str, count: int) -> np.ndarray:
        """All of `pi` or `phi`; NaN where a value is absent."""
        names = (f"{kind}_{k}" for k in range(1, count + 1))
        return np.array([self.values.get(name, np.nan) for name in names])


def write_answer(answer: Answer, path: Path) -> None:
    """As a laboratory gives it for a method of its own."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(vars(answer), indent=1) + "\n")


def read_answer(path: Path) -> Answer:
    """The answer in a file; a recording without one counts as refused."""
    if not path.is_file():
        return Answer(refused="no answer")
    return Answer(**json.loads(path.read_text()))
