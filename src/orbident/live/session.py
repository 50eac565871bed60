"""One run of `orbident live`: lines in, JSON documents out, and a state file."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from orbident.errors import InputError
from orbident.estimation.recursive.given import declared_noise
from orbident.estimation.recursive.prior import cad_prior
from orbident.live.live_filter import LiveEvent, LiveFilter
from orbident.live.sources import Lines
from orbident.live.state_file import nothing_carried, read_state, save_state
from orbident.live.stream_clocks import ALONE, PAUSE, WARM_UP
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
            InputError: the state is damaged or of another robot, or the noise of the
                gyro is not declared.
        """
        # Before any sample: what is sent must not end the run.
        declared_noise(robot, 1.0, velocity_std)
        self._robot, self._state = robot, state
        carried = nothing_carried(robot)
        if state is not None:
            carried = read_state(state, robot, velocity_std)
        self._lines = Lines(robot, source)
        self._filter = LiveFilter(robot, velocity_std, every, carried)
        self._source = source
        self._unreadable = self._unfinished = 0

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
            InputError: the state cannot be written.
        """
        self._unfinished = sum(bool(line.strip()) for line in lines)
        complete = not self._lines.lacking
        samples, unreadable = self._lines.take(lines)
        told = self._filter.take(samples)
        self._unreadable += unreadable
        self._unfinished = 0
        documents = [self._document(event) for event in told]
        if complete and self._lines.lacking and not self._lines.known:
            document = {"event": "unreadable", "t": None, "why": self._lines.lacking}
            documents.insert(0, document)
        for document in documents:
            for sink in sinks:
                sink(document)
        if any(event.kind == "estimate" for event in told):
            self._save()

    def end(self, sinks: Iterable[Sink], lost: int = 0, waiting: int = 0) -> None:
        """Tell what is known at last, and keep the state.

        Args:
            sinks: that are told.
            lost: datagrams that were left out.
            waiting: lines that have come and were not taken.

        Raises:
            InputError: what came gave no estimate, or the state cannot be written.
        """
        at, last = self._filter.carried, self._filter.estimate()
        counts = {
            **at.counts,
            "unreadable": self._unreadable,
            "waiting": at.waiting + self._unfinished + waiting,
        }
        document: dict[str, Any] = {"event": "end", "t": None}
        if last is not None:
            self._save()
            document |= self._document(last) | {"event": "end"}
        document |= {"counts": counts, "lost_datagrams": lost}
        for sink in sinks:
            sink(document)
        if not self._lines.known:
            raise InputError(self._lines.lacking or self._no_columns())
        if last is None:
            came = ", ".join(f"{n} {name}" for name, n in counts.items() if n)
            raise InputError(
                f"{self._source}: no estimate, since the filter begins with {WARM_UP} "
                f"complete samples, at most {PAUSE:g} s apart and in {ALONE:g} s or "
                f"more; found {came}; check what is sent, t is in seconds"
            )

    def _no_columns(self) -> str:
        found = "no line names the columns" if self._unreadable else "no sample came"
        return (
            f"{self._source}: {found}; send a line such as "
            "'t,joint.joint1.position,..' first and then samples, or JSON objects"
        )

    def _save(self) -> None:
        if self._state is not None:
            save_state(self._state, self._filter.carried)

    def _document(self, event: LiveEvent) -> dict[str, Any]:
        document = {"event": event.kind, "t": event.t, **event.of}
        if event.kind == "estimate":
            value, std = event.of["beta"][0], event.of["std"][0]
            told = event.of["scale"]
            document["mass"] = {"value": value, "std": std} if told else None
        return document
