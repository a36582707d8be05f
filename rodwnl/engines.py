"""Who computes the blocks of a sweep: processes on this machine, or a Dask cluster."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rodwnl.batch import PER_ROD, PER_THRESHOLD, landau_batch
from rodwnl.batch_characteristic import Real
from rodwnl.errors import ComputationError, InputError
from rodwnl.storage import require
from rodwnl.workers import begin

PATIENCE = 3  # how often workers may die without a block finished in between
SCHEDULER_TIMEOUT = 10  # seconds

Values = dict[str, NDArray[Any]]
Task = tuple[int, dict[str, Real], float | None, str]


def compute(rods: dict[str, Any], max_force: float | None, model: str) -> Values:
    """The variables for one block of rods; and its failures, as JSON: flat index in the block -> why."""
    batch = landau_batch(**rods, max_force=max_force, model=model)
    values: Values = {name: getattr(batch, name) for name in (*PER_ROD, *PER_THRESHOLD)}
    for name in ("alpha", "beta"):
        numbers = values.pop(name)
        values[f"{name}_re"], values[f"{name}_im"] = numbers.real, numbers.imag
    return values | {"reasons": np.array(json.dumps(batch.reasons))}


def on_this_machine(tasks: Iterable[Task], workers: int) -> Iterator[tuple[int, Values]]:
    """Results as they come, from a pool of processes; what killed workers had is computed again."""
    import multiprocessing

    waiting, deaths = iter(tasks), 0
    again: list[Task] = []
    while True:
        with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), initializer=begin) as pool:
            running: dict[Future[Values], Task] = {}
            try:
                while True:
                    while len(running) < 2 * workers and (
                        task := again.pop() if again else next(waiting, None)
                    ):
                        running[pool.submit(compute, *task[1:])] = task
                    if not running:
                        return
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        values = future.result()
                        deaths = 0
                        yield running.pop(future)[0], values
            except BrokenProcessPool:
                deaths += 1
                again.extend(running.values())
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
        if deaths > PATIENCE:
            raise ComputationError(
                f"worker processes died {deaths} times in a row; is there too little memory for "
                f"{workers} of them? give fewer --workers and --resume"
            )


def on_dask(tasks: Iterable[Task], address: str) -> Iterator[tuple[int, Values]]:
    """Results as they come, from a Dask cluster."""
    distributed = require("distributed", "sweep")
    try:
        client = distributed.Client(address, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"the scheduler {address} does not answer within {SCHEDULER_TIMEOUT} s: {error}"
        ) from None
    with client:
        waiting = iter(tasks)
        numbers: dict[str, int] = {}

        def submit(count: int) -> list[Any]:
            futures = []
            for number, *arguments in islice(waiting, count):
                future = client.submit(compute, *arguments, pure=False)
                numbers[future.key] = number
                futures.append(future)
            return futures

        arriving = distributed.as_completed(
            submit(2 * sum(client.nthreads().values()) or 2), loop=client.loop, with_results=True
        )
        for future, values in arriving:
            yield numbers.pop(future.key), values
            for new in submit(1):
                arriving.add(new)
