"""The charts of a report as figures of matplotlib, for notebooks and papers."""

from dataclasses import dataclass

from orbident.errors import InputError
from orbident.estimation.result import Result
from orbident.estimation.signals import Signals
from orbident.report.budget_section import variance_shares
from orbident.report.conditioning import conditioning
from orbident.report.convergence_section import convergence
from orbident.report.drawing import Drawing, drawn
from orbident.report.fit import charts_of
from orbident.report.page import Section
from orbident.report.parameter_section import masses, parameters
from orbident.report.sensitivity_figure import sensitivities


@dataclass(frozen=True, repr=False)
class Plots:
    """The figures of a result; each method draws one, as a `matplotlib` figure.

    A notebook shows it; `figure.savefig("mass.png")` keeps it.
    """

    result: Result

    def __repr__(self) -> str:
        """What can be drawn."""
        names = "signals(), residuals(), parameters(), mass(), budget(), "
        names += "correlations(), sensitivity(), convergence()"
        return f"figures of {self.result.robot.name}: {names}"

    def signals(self) -> Drawing:
        """What was measured and what is predicted; a panel an axis.

        Raises:
            InputError: the result has no signals.
        """
        signals = self._signals()
        # Of an attitude only the difference is known.
        shown = [signal for signal in signals if signal.sensor != "attitude"] or signals
        return drawn([[next(charts_of(signal))] for signal in shown])

    def residuals(self) -> Drawing:
        """Residuals over time, their spectrum, and their autocorrelation.

        Bands are 95 % of the noise found; of white noise 95 % of the autocorrelation
        lies in its band, and the line in a spectrum is that of white noise.

        Raises:
            InputError: the result has no signals.
        """
        return drawn([list(charts_of(signal))[-3:] for signal in self._signals()])

    def parameters(self) -> Drawing:
        """How far the base parameters are from CAD, with 95 % intervals.

        Those of which CAD says zero, or nearly so, have no percentage.

        Raises:
            InputError: the result is rejected.
        """
        self.result.check_accepted()
        return self._of(parameters(self.result, "CAD"), "no parameter has a percentage")

    def mass(self) -> Drawing:
        """The mass by every route, with 95 % intervals; the line is CAD.

        Raises:
            InputError: the result is rejected, or no route gives a mass.
        """
        self.result.check_accepted()
        return self._of(
            masses(self.result, "CAD"),
            "no route gives a mass, so there is nothing to draw; see result.mass_forms",
        )

    def budget(self) -> Drawing:
        """What the variance of each base parameter is made of, in percent.

        Raises:
            InputError: the result has no budget.
        """
        return self._of(
            variance_shares(self.result),
            "what its deviations are made of is not known: only maximum likelihood "
            "computes it, where the result is accepted and something is noisy",
        )

    def correlations(self) -> Drawing:
        """Correlations of the base parameters.

        Raises:
            InputError: no parameter is determined.
        """
        return self._of(
            conditioning(self.result),
            "no base parameter has a deviation, so there are no correlations to draw",
        )

    def sensitivity(self) -> Drawing:
        """By how many of its deviations an instrument's error would shift a parameter.

        Red is upwards, blue downwards; the number is the size.

        Raises:
            InputError: the result has no sensitivity.
        """
        return self._of(
            sensitivities(self.result),
            "what errors of instruments would shift is not known: only maximum "
            "likelihood computes it, where the result is accepted and some instrument "
            "has no tolerance",
        )

    def convergence(self) -> Drawing:
        """Cost and size of the steps of the search, over their number.

        Each curve is a round: after it the noise and the weights of outliers are
        estimated anew. The search ends below the line.

        Raises:
            InputError: the method does not search, or the result was kept by an
                earlier version.
        """
        return self._of(
            convergence(self.result.convergence),
            f"{self.result.method} has no steps to draw; maximum-likelihood and "
            "structured have",
        )

    def _of(self, section: Section | None, missing: str) -> Drawing:
        """The section's charts beside each other; refused where there are none."""
        if section is None or not section.charts:
            raise InputError(f"{self.result.robot.name}: {missing}")
        return drawn([section.charts])

    def _signals(self) -> Signals:
        signals = self.result.signals()
        if not signals:
            raise InputError(
                f"{self.result.robot.name}: nothing was predicted, so there is nothing "
                "to draw; see result.warnings"
            )
        return signals
