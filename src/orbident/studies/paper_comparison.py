"""A study's parameters beside the paper's own numbers."""

from dataclasses import dataclass
from typing import Any

from orbident.estimation.quantities import nulled
from orbident.studies.spatial import PRINTED

NAN = float("nan")


@dataclass(frozen=True)
class PaperRow:
    """One parameter of a table of the paper, its numbers and ours."""

    name: str
    paper_true: float | None
    paper_error_percent: float | None
    true: float
    estimate: float
    """The estimate of the first seed."""
    rms_error_percent: float = NAN
    """Over the seeds; NaN without noise."""
    worst_error_percent: float = NAN
    cramer_rao_percent: float = NAN
    """The least RMS error that an unbiased estimate can have."""

    @property
    def error_percent(self) -> float:
        """Relative error of the estimate, signed."""
        return 100 * (self.estimate / self.true - 1)

    @property
    def as_printed(self) -> bool:
        """Whether the true value is the paper's, to its printed decimals."""
        return self.paper_true is None or abs(self.true - self.paper_true) <= PRINTED

    def to_json(self) -> dict[str, Any]:
        """As `study --json` gives it."""
        return {
            "name": self.name,
            "paper_true": self.paper_true,
            "paper_error_percent": self.paper_error_percent,
            "true": self.true,
            "estimate": nulled(self.estimate),
            "error_percent": nulled(self.error_percent),
            "rms_error_percent": nulled(self.rms_error_percent),
            "worst_error_percent": nulled(self.worst_error_percent),
            "cramer_rao_percent": nulled(self.cramer_rao_percent),
        }
