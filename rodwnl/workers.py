"""Processes that share the work of one command."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import wait
from threading import Thread

from rodwnl.errors import ComputationError


@contextmanager
def processes(count: int | None = None) -> Iterator[Executor]:
    """An executor of so many new processes, one a core by default; an exception gives up what waits.

    A script that uses it needs the guard `if __name__ == "__main__":`. Raises ComputationError where a
    process was killed.
    """
    with ProcessPoolExecutor(count or cores(), multiprocessing.get_context("spawn"), begin) as pool:
        try:
            yield pool
        except BrokenProcessPool:
            raise ComputationError("a worker process was killed; is there too little memory?") from None
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def cores() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def begin() -> None:
    """A worker ends silently on Ctrl-C, and when the command that started it is gone, killed perhaps."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    if parent is not None:
        Thread(target=lambda: (wait([parent.sentinel]), os._exit(1)), daemon=True).start()
