"""Tasks on processes and on a Dask cluster: a worker that dies loses no result."""

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from conftest import run_cli
from gprodom.cluster import open_executor
from gprodom.errors import Error, UsageError
from gprodom.executor import Answer, Call, Executor, LocalExecutor

WORKERS = 2


def echo(number: int) -> Call:
    return Call(("echo", str(number)), {}, 60)


def kills_its_worker(marker: Path, always: bool = False) -> Call:
    """Once, or each time. The shell's parent is the worker."""
    once = "true" if always else f"[ ! -e {marker} ]"
    script = f"if {once}; then touch {marker}; kill -9 $PPID; else echo lived; fi"
    return Call(("sh", "-c", script), {}, 60)


def outputs(executor: Executor, tasks: list[Call]) -> dict[int, str]:
    """By number of the task; of those that fail, why."""
    found: dict[int, str] = {}
    for index, finished in executor.run(tasks):
        assert index not in found
        try:
            answer: Answer = finished.result()
            found[index] = answer.output.strip()
        except Error as error:
            found[index] = str(error)
    return found


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """The address of a scheduler with two workers, which are not started again when they end."""
    if find_spec("distributed") is None:
        pytest.skip("distributed is not installed (the extra cluster)")
    from distributed import Client

    file = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    said = (tmp_path / "said.txt").open("w")
    common = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file)]
    commands = [[*dask, "scheduler", "--port", "0", "--no-show", *common]]
    more = ["--nthreads", "1", "--no-nanny", "--local-directory", str(tmp_path)]
    commands += [[*dask, "worker", *more, *common]] * WORKERS
    running = [subprocess.Popen(command, stdout=said, stderr=said) for command in commands]
    try:
        client = Client(scheduler_file=str(file), timeout=60, set_as_default=False)
        client.wait_for_workers(WORKERS, timeout=60)
        client.close()
        yield str(json.loads(file.read_text())["address"])
    finally:
        for process in running:
            process.kill()
            process.wait()
        said.close()


def test_processes_of_this_machine(tmp_path: Path) -> None:
    tasks = [*map(echo, range(4)), kills_its_worker(tmp_path / "once"), *map(echo, range(5, 9))]
    found = outputs(LocalExecutor(WORKERS), tasks)
    assert found == {i: "lived" if i == 4 else str(i) for i in range(9)}


def test_a_task_that_always_ends_its_worker_fails_alone(tmp_path: Path) -> None:
    tasks = [kills_its_worker(tmp_path / "always", always=True), *map(echo, range(1, 9))]
    found = outputs(LocalExecutor(WORKERS), tasks)
    assert "ended without a word 3 times" in found.pop(0)
    assert found == {i: str(i) for i in range(1, 9)}


def test_a_dead_worker_ends_the_others_though_the_command_line_takes_signals(
    tmp_path: Path,
) -> None:
    def stop(*_: object) -> None:
        raise SystemExit(143)

    before = signal.signal(signal.SIGTERM, stop)
    try:
        tasks = [kills_its_worker(tmp_path / "once"), Call(("sleep", "1"), {}, 60)]
        assert outputs(LocalExecutor(WORKERS), tasks) == {0: "lived", 1: ""}
    finally:
        signal.signal(signal.SIGTERM, before)


def test_what_takes_too_long_is_ended() -> None:
    answer = Call(("sleep", "60"), {}, 0.1)()
    assert answer.code != 0
    assert "took more than" in answer.said


def test_a_worker_of_a_cluster_that_dies_loses_no_result(scheduler: str, tmp_path: Path) -> None:
    with open_executor(1, scheduler) as executor:
        assert executor.workers == WORKERS
        tasks = [*map(echo, range(4)), kills_its_worker(tmp_path / "once"), *map(echo, range(5, 9))]
        assert outputs(executor, tasks) == {i: "lived" if i == 4 else str(i) for i in range(9)}
        assert executor.workers == WORKERS - 1


@pytest.mark.usefixtures("compiled")
def test_a_benchmark_is_the_same_on_a_cluster(scheduler: str, tmp_path: Path) -> None:
    drives = ["--simulate", "2", "--grounds", "rays", "--distance", "8"]
    command = ["benchmark", *drives, "--methods", "wheel,imu_wheel", "-o"]
    run_cli(*command, tmp_path / "here", "-j", "2")
    run_cli(*command, tmp_path / "there", "--scheduler", scheduler)
    tables = [(tmp_path / where / "results.csv").read_bytes() for where in ("here", "there")]
    assert tables[0] == tables[1] and len(tables[0].splitlines()) == 1 + 2 * 3


def test_a_scheduler_open_to_a_network_needs_tls() -> None:
    pytest.importorskip("distributed", reason="distributed is not installed (the extra cluster)")
    for address in ("tcp://192.0.2.1:8786", "192.0.2.1:8786", "tcp://some.host:8786"):
        with pytest.raises(UsageError, match="needs TLS"), open_executor(1, address):
            pass
    for address in ("tcp://127.0.0.1", "http://127.0.0.1:8786", "127.0.0.1:port"):
        with pytest.raises(UsageError, match="expected tcp://"), open_executor(1, address):
            pass
