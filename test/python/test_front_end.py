"""A radar front end written in Python, in the estimator in place of gpr.front_end."""

import gc
import runpy
import weakref
from typing import Any

import numpy as np
import pytest

import gprodom
from conftest import CHECKOUT, SAMPLE
from gprodom.convert.cmu import Recording, read_recording

pytestmark = pytest.mark.usefixtures("compiled")

TICK = 100_000_000  # ns


@pytest.fixture(scope="module")
def recording() -> Recording:
    return read_recording(SAMPLE)


class Silent:
    """Says nothing, and remembers what it was told."""

    def __init__(self) -> None:
        self.traces: list[Any] = []
        self.ticks: list[int] = []

    def add_trace(self, trace: Any) -> None:
        self.traces.append((trace.time, trace.samples, trace.sample_interval))

    def tick(self, time: int) -> list[Any]:
        self.ticks.append(time)
        return []

    def reset(self) -> None:
        self.traces.clear()


def test_that_of_the_examples_finds_standstills_and_distances(recording: Recording) -> None:
    names = runpy.run_path(str(CHECKOUT / "examples" / "python" / "front_end.py"))
    odometry = gprodom.Odometry(front_end=names["Similarity"])
    out = odometry.run(**recording.messages(until=int(recording.imu_utime[0] + 40_000_000)))
    found = [d for d in out.displacements if d["source"] == "similarity" and d["valid"]]
    standing = [d for d in found if d["distance"] == 0]
    wheel = recording.messages()["wheel_distance"]
    for displacement in standing:
        since, until = np.interp(
            [displacement["from"], displacement["to"]], recording.wheel_utime * 1000, wheel
        )
        assert abs(until - since) < 0.02
    assert min(len(standing), len(found) - len(standing)) > 10


def test_it_gets_each_trace_and_tick_and_is_not_needed(recording: Recording) -> None:
    made: list[Silent] = []

    def make() -> Silent:
        made.append(Silent())
        return made[-1]

    own = gprodom.Odometry(front_end=make).run(**recording.messages())
    none = gprodom.Odometry(set=["gpr.front_end=none"]).run(**recording.messages())
    [front_end] = made
    assert np.all(np.diff(front_end.ticks) == TICK)
    times = np.array([time for time, _, _ in front_end.traces])
    assert np.all(np.isin(times, recording.gpr_utime * 1000))
    assert len(times) > 0.98 * len(recording.gpr_utime)
    time, samples, interval = front_end.traces[-1]
    [index] = np.nonzero(recording.gpr_utime * 1000 == time)[0]
    np.testing.assert_array_equal(samples, recording.traces[index].astype(np.float32))
    assert interval == recording.sample_interval
    np.testing.assert_array_equal(own.odometry["position"], none.odometry["position"])


def test_its_displacements_carry_a_robot_without_a_wheel(recording: Recording) -> None:
    messages = recording.messages()
    wheel_time, wheel = messages["wheel_time"], messages["wheel_distance"]

    class Told:
        """What the wheel says, as if the radar had seen it."""

        def add_trace(self, trace: Any) -> None:
            pass

        def tick(self, time: int) -> list[Any]:
            since, until = np.interp([time - TICK, time], wheel_time, wheel)
            return [gprodom.gpr.TrackDisplacement(time - TICK, time, until - since, 0.003)]

        def reset(self) -> None:
            pass

    def path(settings: list[str], front_end: Any) -> Any:
        odometry = gprodom.Odometry(set=["graph.enabled=false", *settings], front_end=front_end)
        return odometry.run(**messages).odometry["position"]

    wheeled, told = path([], Silent), path(["wheel.enabled=false"], Told)
    untold = path(["wheel.enabled=false"], Silent)
    off, far_off = (np.linalg.norm(p - wheeled, axis=1).max() for p in (told, untold))
    assert off < 0.1 * far_off  # aside and up nothing holds it but the IMU


class Standing(Silent):
    def tick(self, time: int) -> list[Any]:
        return [gprodom.gpr.Standstill(time - 3 * TICK, time, 0.001, source="mine", score=0.5)]


def test_its_standstills_are_published(recording: Recording) -> None:
    until = int(recording.imu_utime[0] + 10_000_000)
    out = gprodom.Odometry(front_end=Standing).run(**recording.messages(until=until))
    mine = [found for found in out.displacements if found["source"] == "mine"]
    assert len(mine) > 80
    assert {(found["distance"], found["sigma"], found["score"]) for found in mine} == {
        (0.0, 0.001, 0.5)
    }


def feed(odometry: Any, recording: Recording, seconds: float) -> None:
    odometry.run(**recording.messages(until=int(recording.imu_utime[0] + 1_000_000 * seconds)))


def test_what_it_raises_comes_out_of_the_estimator(recording: Recording) -> None:
    class Broken(Silent):
        def tick(self, time: int) -> list[Any]:
            raise ZeroDivisionError("of mine")

    class Wrong(Silent):
        def tick(self, time: int) -> list[Any]:
            return [0.1]

    with pytest.raises(ZeroDivisionError, match="of mine"):
        feed(gprodom.Odometry(front_end=Broken), recording, 5.0)
    with pytest.raises(TypeError, match="expected a list of Standstill"):
        feed(gprodom.Odometry(front_end=Wrong), recording, 5.0)


def test_a_class_without_the_three_functions_is_refused() -> None:
    with pytest.raises(TypeError, match="there is no add_trace"):
        gprodom.Odometry(front_end=object)
    with pytest.raises(TypeError):
        gprodom.Odometry(front_end=3)


def test_it_is_made_anew_after_a_reset_and_let_go_at_the_end(recording: Recording) -> None:
    alive: list[Any] = []

    def make() -> Silent:
        front_end = Silent()
        alive.append(weakref.ref(front_end))
        return front_end

    odometry = gprodom.Odometry(front_end=make)
    feed(odometry, recording, 5.0)
    odometry.forget()
    assert [front_end() is None for front_end in alive] == [True, False]
    del odometry
    gc.collect()
    assert [front_end() is None for front_end in alive] == [True, True]
