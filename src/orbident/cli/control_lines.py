"""The control study as a table for people."""

from typing import Any

from rich.table import Table


def control_lines(done: Any) -> list[Any]:
    """Tracking errors with either model, and by how much they differ."""
    table = Table("torques computed from", box=None)
    for name in ("joints, rad RMS", "base, rad RMS"):
        table.add_column(name, justify="right")
    for name, tracked in done.errors.items():
        cells = (f"{tracked.joints:.3g}", f"{tracked.base:.3g}")
        table.add_row(f"the {name} model", *cells)
    runs = "1 run" if done.seeds == 1 else f"{done.seeds} seeds"
    return [
        "arm and base tracked in free flight, CAD off by 20 % in masses, first moments "
        f"and inertias: {runs}",
        "",
        table,
        "",
        f"at least {done.factor:.3g} times better with the identified model, "
        f"{done.elapsed_s:.1f} s",
    ]
