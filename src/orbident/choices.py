"""Words that a person chooses from, for the functions and for the command alike."""

from typing import Literal

Method = Literal["maximum-likelihood", "structured", "least-squares", "recursive"]
"""How parameters are estimated."""

InitialMomentum = Literal["unknown", "at-rest", "first-sample"]
"""What is known of the momentum (Section 3.1)."""

Objective = Literal["cond", "d", "a", "e"]
"""What a motion that is designed makes small."""

SensorNoise = Literal["none", "sensors"]
"""Who measures in a simulation."""

StudyNoise = Literal["none", "paper"]
"""What sensors add in a study."""
