"""How far a command has come: a bar on a terminal's stderr, lines now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Watch = Callable[[str, int, int], None]  # what was done last, steps done, steps in all

QUIET = 10.0  # seconds between two lines


def silent(text: str, done: int, total: int) -> None:
    """Tell nobody."""


@contextmanager
def progress() -> Iterator[Watch]:
    """Something to call after each step."""
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

        columns = BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("{task.description}")
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task("", total=None)
            yield lambda text, done, total: bar.update(task, description=text, completed=done, total=total)
        return
    last = time.monotonic()

    def line(text: str, done: int, total: int) -> None:
        nonlocal last
        if time.monotonic() - last >= QUIET:
            last = time.monotonic()
            print(f"{done} of {total} steps: {text}", file=sys.stderr, flush=True)

    yield line
