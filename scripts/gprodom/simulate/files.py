"""Writes a simulated sequence as the CMU-GPR dataset does, and its truth beside it."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from gprodom.arrays import Floats, Ints
from gprodom.convert.cmu import Traces
from gprodom.convert.sampling import radar_facts
from gprodom.convert.source import RADAR_FACTS
from gprodom.files import write_bytes, write_npz, zip_bytes
from gprodom.lcm.log_writer import write_log
from gprodom.simulate.pair import PairData
from gprodom.simulate.recording import log_streams
from gprodom.simulate.sequence import Simulated


def write_sequence(simulated: Simulated, output: Path) -> list[Path]:
    """Writes `output`, a zip or LCM log where so named, else a directory, and the truth beside it.

    Only a log holds left and right wheels; in the dataset's format their mean is the wheel.

    The truth, for tests of the parts: ``.truth.npz`` (t, s, x, y, yaw, v at 20 Hz, and the IMU's
    biases) and ``.json`` (wheel scale, slip episodes, what was simulated; of several antennas the
    lever arms by tape, `antennas`, and true, `antennas_true`, m). Returns the paths.
    """
    name = output.name.removesuffix(".zip").removesuffix(".lcmlog")
    files = {}
    if output.suffix == ".lcmlog":
        write_log(output, log_streams(simulated))
    else:
        files = {file: content.encode() for file, content in _tables(simulated).items()}
        if simulated.sample_interval is not None:
            files[RADAR_FACTS] = radar_facts(simulated.sample_interval)
    if output.suffix == ".zip":
        write_bytes(output, zip_bytes({f"{name}/{file}": data for file, data in files.items()}))
    elif files:
        output.mkdir(exist_ok=True)
        for file, data in files.items():
            write_bytes(output / file, data)
    truth, facts = (output.with_name(name + suffix) for suffix in (".truth.npz", ".json"))
    write_npz(truth, _truth(simulated))
    write_bytes(facts, (json.dumps(_facts(simulated), indent=1) + "\n").encode())
    return [output, truth, facts]


def _csv(header: str, utime: Ints, rows: Iterable[str]) -> str:
    """CRLF lines as in the dataset, times with microseconds."""
    lines = [header]
    lines += [
        f"{time // 1_000_000}.{time % 1_000_000:06d},{row}"
        for time, row in zip(utime.tolist(), rows, strict=True)
    ]
    return "\r\n".join(lines) + "\r\n"


def _tables(simulated: Simulated) -> dict[str, str]:
    imu = simulated.imu
    columns = np.hstack([imu.acceleration, imu.angular_velocity, imu.orientation])
    distance = simulated.wheel.ticks * simulated.spec.wheel.quantum
    tables = {
        "imu_meas.csv": _csv(
            "t_stamp,a_x,a_y,a_z,g_x,g_y,g_z,w,x,y,z",
            simulated.imu_utime,
            (",".join(f"{value:.8g}" for value in row) for row in columns.tolist()),
        ),
        "we_odom_meas.csv": _csv(
            "Time[s],Range[m]", simulated.wheel_utime, (f"{d:.6f}" for d in distance.tolist())
        ),
        "gpr_meas.csv": _traces(Traces(simulated.gpr_utime, simulated.traces)),
        "ts_meas.csv": _csv(
            "Time[s],Px[m],Py[m],Pz[m]",
            simulated.station_utime,
            (",".join(f"{value:.5f}" for value in row) for row in simulated.station.tolist()),
        ),
    }
    for id_, of in simulated.more_antennas.items():
        tables[f"gpr_meas_{id_}.csv"] = _traces(of)
    return tables


def _traces(of: Traces) -> str:
    amplitudes = ",".join(f"amp_{i + 1}" for i in range(of.counts.shape[1]))
    rows = (",".join(map(str, row)) for row in of.counts.tolist())
    return _csv(f"t_stamp,{amplitudes}", of.utime, rows)


def _truth(simulated: Simulated) -> dict[str, Floats]:
    motion = simulated.truth
    nearest = np.searchsorted(simulated.imu_utime, simulated.truth_utime)
    nearest = np.minimum(nearest, len(simulated.imu_utime) - 1)
    return {
        "t": simulated.truth_utime * 1e-6,
        **{name: getattr(motion, name) for name in ("s", "x", "y", "yaw", "v")},
        "accel_bias": simulated.imu.accel_bias[nearest],
        "gyro_bias": simulated.imu.gyro_bias[nearest],
    }


def _facts(simulated: Simulated) -> dict[str, Any]:
    spec, drive = simulated.spec, simulated.drive
    slips = spec.wheel.slips
    written = asdict(spec)
    for each in (written["radar"], *(antenna["radar"] for antenna in written["antennas"])):
        if not each["spacing"]:
            del each["spacing"]
    if not any(spec.imu.lever_arm):
        del written["imu"]["lever_arm"]
    antennas: dict[str, Any] = {}
    if spec.antennas:
        antennas["antennas"] = [[*antenna.told, 0.0] for antenna in spec.antennas]
        antennas["antennas_true"] = [[*a.radar.lever_arm, 0.0] for a in spec.antennas]
    else:
        del written["antennas"]
    return {
        "scale": float(simulated.wheel.scale[0]),
        "pair": None if simulated.pair is None else _pair_facts(simulated.pair),
        "slip": [[slip.start, slip.duration, slip.factor] for slip in slips],
        "spin": [[slip.start, slip.duration, slip.spin] for slip in slips if slip.spin],
        "dist": float(simulated.truth.travelled[-1]),
        "dur": drive.duration,
        "kind": spec.kind,
        "bg": simulated.imu.gyro_bias[0].tolist(),
        "ba": simulated.imu.accel_bias[0].tolist(),
        "gpr_sample_interval": simulated.sample_interval,
        "seed": simulated.seed,
        "spec": written,
        **antennas,
    }


def _pair_facts(pair: PairData) -> dict[str, float]:
    return {"scale": pair.scale, "track": pair.track, "radii": pair.radii}
