"""One run of `orbident live`: lines in, JSON documents out, and a state file."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.estimation.recursive.prior import cad_prior
from orbident.live.lines import Lines
from orbident.live.live_filter import WARM_UP, Event, LiveFilter
from orbident.live.state_file import nothing_carried, read_state, save_state
from orbident.model.formulas import formulas_of
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot

Sink = Callable[[dict[str, Any]], object]
"""Takes a document that can be written as JSON."""


class Session:
    """Lines in, documents out."""

    def __init__(
        self,
        robot: Robot,
        source: str,
        every: float,
        velocity_std: float | None,
        state: Path | None,
    ) -> None:
        """Go on from the state file, where there is one.

        Args:
            robot: whose samples come.
            source: where they come from, for messages.
            every: time of the samples between two estimates, s.
            velocity_std: of a velocity sample, m/s; None where none counts.
            state: file to begin from and to write to.

        Raises:
            InputError: the state is damaged or of another robot.
        """
        self._robot, self._state = robot, state
        carried = nothing_carried(robot)
        if state is not None:
            carried = read_state(state, robot, velocity_std)
        self._lines = Lines(robot, source)
        self._filter = LiveFilter(robot, velocity_std, every, carried)
        self._source = source
        self._whole = True

    def start(self) -> dict[str, Any]:
        """The first document: names, formulas, and what is believed beforehand."""
        prior = cad_prior(self._robot)
        base = formulas_of(self._robot, minimal_sets(self._robot)).base
        std = np.linalg.norm(np.linalg.inv(prior.root), axis=1)
        resumed = self._filter.estimate()
        return {
            "event": "start",
            "robot": self._robot.name,
            "names": list(base.names),
            "formulas": list(base.formulas),
            "beta": prior.beta.tolist(),
            "std": std.tolist(),
            "resumed_at": None if resumed is None else resumed.t,
        }

    def take(self, lines: Sequence[bytes], sinks: Iterable[Sink]) -> None:
        """Take some lines in, and tell what they say.

        Raises:
            InputError: the first header lacks a column, the noise of the gyro is not
                declared, or the state cannot be written.
        """
        self._whole = False
        told = self._filter.take(self._lines.take(lines))
        self._whole = True
        for event in told:
            document = self._document(event)
            for sink in sinks:
                sink(document)
        if any(event.kind == "estimate" for event in told):
            self._save()

    def end(self, sinks: Iterable[Sink], lost: int = 0) -> None:
        """Tell what is known at last, and keep the state.

        Args:
            sinks: that are told.
            lost: datagrams that were left out.

        Raises:
            InputError: what came gave no estimate, or the state cannot be written.
        """
        # What was interrupted within a step is not to be gone on from.
        if self._whole:
            self._save()
        last = self._filter.estimate()
        counts = {**self._filter.carried.counts, "unreadable": self._lines.unreadable}
        document: dict[str, Any] = {"event": "end", "t": None, "counts": counts}
        if last is not None:
            document |= self._document(last) | {"event": "end", "counts": counts}
        document["lost_datagrams"] = lost
        for sink in sinks:
            sink(document)
        if not self._lines.known:
            raise InputError(self._no_columns())
        if last is None:
            raise InputError(
                f"{self._source}: no estimate, since the filter begins with "
                f"{WARM_UP} samples of which one is complete; "
                f"{len(self._filter.carried.held)} with a time came, and "
                f"{self._lines.unreadable} lines that are no sample: check what is sent"
            )

    def _no_columns(self) -> str:
        found = (
            "no line names the columns" if self._lines.unreadable else "no sample came"
        )
        return (
            f"{self._source}: {found}; send a line such as "
            "'t,joint.joint1.position,..' first and then samples, or JSON objects"
        )

    def _save(self) -> None:
        if self._state is not None:
            save_state(self._state, self._filter.carried)

    def _document(self, event: Event) -> dict[str, Any]:
        document = {"event": event.kind, "t": event.t, **event.of}
        if event.kind == "estimate":
            value, std = event.of["beta"][0], event.of["std"][0]
            told = event.of["scale"]
            document["mass"] = {"value": value, "std": std} if told else None
        return document
