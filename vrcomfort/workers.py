"""Workers: this process, processes of this machine, or a Dask cluster; the same code."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from typing import Any, TypeAlias, TypeVar

from vrcomfort.errors import InputError, pip_install

Item = TypeVar("Item")
Result = TypeVar("Result")
Work: TypeAlias = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]]
"""Calls a function for every item, and yields results as they come (in any order)."""

CONNECT_S = 10.0


@contextmanager
def workers(jobs: int, cluster: str | None) -> Iterator[Work]:
    """Yield an executor; nothing is left running afterwards.

    Parameters
    ----------
    jobs
        Processes on this machine; 1 works in this one.
    cluster
        Address of a running Dask scheduler, whose workers take the place of `jobs`.

    Raises
    ------
    InputError
        If no scheduler answers at the address.
    """
    if cluster is not None:
        with _dask_client(cluster) as client:
            yield lambda function, items: _spread(client.get_executor(pure=False), function, items)
    elif jobs == 1:
        yield map
    else:
        with _processes(jobs) as pool:
            yield lambda function, items: _spread(pool, function, items)


def _spread(
    executor: Executor, function: Callable[[Item], Result], items: Iterable[Item]
) -> Iterator[Result]:
    with _ctrl_c_later():
        futures = [executor.submit(function, item) for item in items]
    try:
        for future in as_completed(futures):
            yield future.result()
    finally:
        for future in futures:
            future.cancel()


@contextmanager
def _ctrl_c_later() -> Iterator[None]:
    """Hold Ctrl-C back. Processes that start meanwhile never hear it: this one ends them.

    Nor do they hear that the terminal was closed, which is told to all as Ctrl-C is.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _processes(jobs: int) -> Iterator[ProcessPoolExecutor]:
    # OpenGL does not survive a fork. Each process rasterises with its share of the cores.
    os.environ.setdefault("LP_NUM_THREADS", str(max(1, (os.cpu_count() or 1) // jobs)))
    pool = ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn"))
    try:
        yield pool
    except BaseException:
        for process in multiprocessing.active_children():
            process.terminate()  # what it has not finished is begun again: nobody waits for it
        raise
    finally:
        os.environ.pop("LP_NUM_THREADS", None)
        pool.shutdown(cancel_futures=True)


@contextmanager
def _dask_client(address: str) -> Iterator[Any]:
    try:
        from distributed import Client  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise InputError(f"--cluster needs Dask; {pip_install('distributed')}") from error
    try:
        client = Client(  # type: ignore[no-untyped-call]
            address, timeout=CONNECT_S, set_as_default=False
        )
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"no Dask scheduler answers at {address!r}; start one with 'dask scheduler' and give "
            "its address, for example tcp://host:8786"
        ) from error
    with client:
        if not client.scheduler_info()["workers"]:
            raise InputError(
                f"the Dask scheduler at {address} has no workers; start some with 'dask worker'"
            )
        yield client
