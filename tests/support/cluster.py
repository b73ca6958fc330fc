"""A Dask cluster on this machine that a busy one does not make impatient."""

from __future__ import annotations

import gc
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.support.waiting import WAIT_S


@contextmanager
def local_cluster(workers: int) -> Iterator[str]:
    """Yield the address of a scheduler with so many workers."""
    distributed = pytest.importorskip("distributed", reason="distributed is not installed")
    import dask

    patient = {f"distributed.comm.timeouts.{name}": f"{WAIT_S}s" for name in ("connect", "tcp")}
    with (
        pytest.MonkeyPatch.context() as patch,
        dask.config.set(patient),
        distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, dashboard_address=None, protocol="tcp"
        ) as cluster,
    ):
        patch.setattr("vrcomfort.workers.CONNECT_S", WAIT_S)
        yield cluster.scheduler_address
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # of what Dask leaves to be collected
        gc.collect()
