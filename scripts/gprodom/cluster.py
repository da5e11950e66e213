"""Tasks on this machine, or on the workers of a Dask cluster (the extra `cluster`)."""

import hashlib
import ipaddress
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from gprodom.errors import Error, UsageError, need_module
from gprodom.executor import MOST_LOSSES, Executor, Finished, LocalExecutor
from gprodom.odometry.replay import find_program
from gprodom.own_code import digest_of_code

Result = TypeVar("Result")
CONNECT_S = 10.0


def check_address(address: str) -> str:
    """The address with its protocol. Whoever reaches a scheduler has its workers execute code, so
    it must not be open to a network: it is on this machine, or asks for a certificate (TLS)."""
    protocol, found, rest = address.rpartition("://")
    if not found:
        protocol = "tcp"
    host, port_found, port = rest.rpartition(":")
    if not (port_found and host and port.isdigit()) or protocol not in ("tcp", "tls"):
        raise UsageError(f"--scheduler {address}: expected tcp://127.0.0.1:PORT or tls://HOST:PORT")
    if protocol == "tcp" and not _is_here(host.strip("[]")):
        raise UsageError(
            f"--scheduler {address}: a scheduler executes what anybody sends to it, so over a "
            "network it needs TLS: tls://HOST:PORT"
        )
    return f"{protocol}://{rest}"


def _is_here(host: str) -> bool:
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def identity() -> str:
    """Of what computes figures in this process: package and replay program."""
    return f"{digest_of_code()} {hashlib.sha256(find_program().read_bytes()).hexdigest()}"


class DaskExecutor:
    """The workers of a scheduler, each with the same program and the same files as here."""

    def __init__(self, address: str) -> None:
        checked = check_address(address)
        distributed = need_module("distributed", "cluster")
        try:
            self._client = distributed.Client(checked, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:  # of no answer, and of TLS without certificates
            raise Error(f"no scheduler at {checked}: {error}") from None
        self._distributed = distributed
        try:
            self._check_workers()
        except BaseException:
            self.close()
            raise

    def _check_workers(self) -> None:
        versions = self._client.run(_distributed_version)
        if not versions:
            raise Error("the scheduler has no workers: dask worker ADDRESS")
        here = _distributed_version()
        for worker, version in versions.items():
            if version != here:
                raise Error(f"{worker} has distributed {version}, this is {here}")
        wanted = identity()
        for worker, found in self._client.run(identity, on_error="return").items():
            if isinstance(found, Exception):
                raise Error(f"{worker} has no gprodom that runs: {found}")
            if found != wanted:
                raise Error(f"{worker} has another gprodom than this: start it from this checkout")

    @property
    def workers(self) -> int:
        """Tasks at once."""
        info = self._client.scheduler_info(n_workers=-1)
        return max(1, sum(int(each["nthreads"]) for each in info["workers"].values()))

    def run(self, tasks: Sequence[Callable[[], Result]]) -> Iterator[tuple[int, Finished[Result]]]:
        """See `gprodom.executor.Executor`."""
        futures = {self._client.submit(_call, task, pure=False): i for i, task in enumerate(tasks)}
        try:
            for future in self._distributed.as_completed(list(futures), loop=self._client.loop):
                yield futures.pop(future), _Ended(future, self._distributed.KilledWorker)
        finally:
            self._client.cancel(list(futures))

    def close(self) -> None:
        """Leaves the workers."""
        self._client.close()


class _Ended:
    """A task that has ended there."""

    def __init__(self, future: Any, killed: type[BaseException]) -> None:
        self._future, self._killed = future, killed

    def result(self) -> Any:
        """See `gprodom.executor.Finished`."""
        try:
            return self._future.result()
        except self._killed:
            raise Error(f"its worker ended without a word {MOST_LOSSES} times") from None


@contextmanager
def open_executor(workers: int, scheduler: str | None = None) -> Iterator[Executor]:
    """Processes of this machine, or the workers of the scheduler of that address."""
    if scheduler is None:
        yield LocalExecutor(workers)
        return
    executor = DaskExecutor(scheduler)
    try:
        yield executor
    finally:
        executor.close()


def _call(task: Callable[[], Result]) -> Result:
    return task()


def _distributed_version() -> str:
    return str(sys.modules["distributed"].__version__)
