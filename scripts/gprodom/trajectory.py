"""A trajectory on arrays, its interpolation, and TUM files."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gprodom import rotation
from gprodom.arrays import Bools, Floats, Ints
from gprodom.errors import Error
from gprodom.files import replacing
from gprodom.times import to_microseconds

Times = Ints  # us since 1970


@dataclass(frozen=True)
class Trajectory:
    """Poses in time order.

    time: (n,) int64, microseconds since 1970. position: (n, 3), metres.
    orientation: (n, 4) unit quaternions w x y z (R_world_body), or None: points only.
    covariance: (n, 6, 6) of [position (m), rotation vector (rad)] in world axes, or None.
    """

    time: Times
    position: Floats
    orientation: Floats | None = None
    covariance: Floats | None = None

    def __len__(self) -> int:
        return int(self.time.size)

    def seconds(self) -> Floats:
        """Times (n,) in seconds after the first pose."""
        return np.asarray(self.time - self.time[0], dtype=float) * 1e-6

    def select(self, index: Bools | Ints) -> "Trajectory":
        """The poses that `index` (mask or indices) picks."""
        return Trajectory(
            self.time[index],
            self.position[index],
            None if self.orientation is None else self.orientation[index],
            None if self.covariance is None else self.covariance[index],
        )

    def moved(self, lever: Floats) -> "Trajectory":
        """The path of the point at `lever` (3, metres, body frame). Needs orientations."""
        if self.orientation is None:
            raise Error(
                "a lever arm needs a trajectory with orientations; this one has points only"
            )
        offset = np.einsum("nij,j->ni", rotation.to_matrix(self.orientation), lever)
        return Trajectory(self.time, self.position + offset, self.orientation, self.covariance)

    def transformed(self, matrix: Floats, translation: Floats) -> "Trajectory":
        """`matrix` (3, 3) p + `translation` (3) of every pose; covariances turn along."""
        orientation, covariance = self.orientation, self.covariance
        if orientation is not None:
            orientation = rotation.multiply(rotation.from_matrix(matrix), orientation)
        if covariance is not None:
            turn = np.kron(np.eye(2), matrix)
            covariance = turn @ covariance @ turn.T
        return Trajectory(
            self.time, self.position @ matrix.T + translation, orientation, covariance
        )


def joined(parts: Sequence[Trajectory]) -> Trajectory:
    """One after the other, with attitudes and covariances where all have them."""

    def together(values: list[Floats | None]) -> Floats | None:
        known = [value for value in values if value is not None]
        return np.concatenate(known) if len(known) == len(values) else None

    return Trajectory(
        np.concatenate([part.time for part in parts]),
        np.concatenate([part.position for part in parts]),
        together([part.orientation for part in parts]),
        together([part.covariance for part in parts]),
    )


def without_repeats(trajectory: Trajectory) -> Trajectory:
    """Sorted by time, of poses with equal stamps the last one kept."""
    order = np.argsort(trajectory.time, kind="stable")
    time = trajectory.time[order]
    last = np.append(time[1:] != time[:-1], True) if time.size else np.zeros(0, dtype=bool)
    return trajectory.select(order[last])


def interpolate(trajectory: Trajectory, time: Times) -> Trajectory:
    """Poses at `time` (m,), which must lie inside the trajectory.

    Positions and covariances linearly, orientations by slerp. The trajectory's stamps must increase
    strictly (`without_repeats`).
    """
    right = np.clip(np.searchsorted(trajectory.time, time), 1, max(len(trajectory) - 1, 1))
    if len(trajectory) == 1:
        return trajectory.select(np.zeros(time.size, dtype=np.int64))
    left = right - 1
    span = (trajectory.time[right] - trajectory.time[left]).astype(float)
    weight = (time - trajectory.time[left]).astype(float) / span
    k = weight[:, None]
    orientation, covariance = trajectory.orientation, trajectory.covariance
    return Trajectory(
        time,
        (1 - k) * trajectory.position[left] + k * trajectory.position[right],
        None
        if orientation is None
        else rotation.slerp(orientation[left], orientation[right], weight),
        None
        if covariance is None
        else (1 - k[..., None]) * covariance[left] + k[..., None] * covariance[right],
    )


def thin(path: Trajectory, period_us: int) -> Trajectory:
    """About one pose in `period_us`, the first and the last among them."""
    kept = np.concatenate([[0], np.flatnonzero(np.diff(path.time // period_us)), [len(path) - 1]])
    return path.select(np.unique(kept))


def path_length(position: Floats, min_step_m: float = 0.05) -> Floats:
    """Distance travelled (n,), metres, along positions (n, d), counted in steps of at least
    `min_step_m`, so that the noise of a standing robot does not add up."""
    travelled = np.zeros(len(position))
    anchor, total = 0, 0.0
    for i in range(1, len(position)):
        step = float(np.linalg.norm(position[i] - position[anchor]))
        if step >= min_step_m:
            total += step
            anchor = i
        travelled[i] = total
    return travelled


def read_tum(path: Path) -> Trajectory:
    """A TUM file: `t x y z qx qy qz qw` a line, seconds and metres; `#` begins a comment.

    Where every quaternion is the identity (or zero) the file is taken to hold points only.
    """
    times: list[int] = []
    rows: list[list[float]] = []
    with path.open(encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            fields = line.split("#", 1)[0].replace(",", " ").split()
            if not fields:
                continue
            try:
                if len(fields) != 8:
                    raise ValueError
                values = [float(field) for field in fields[1:]]
                times.append(to_microseconds(fields[0].encode()))
            except ValueError:
                raise Error(f"{path}:{number}: expected 8 numbers: t x y z qx qy qz qw") from None
            if not np.all(np.isfinite(values)):
                raise Error(f"{path}:{number}: expected finite numbers")
            rows.append(values)
    if not rows:
        raise Error(f"{path}: holds no poses; expected lines of t x y z qx qy qz qw")
    data = np.array(rows)
    return without_repeats(
        Trajectory(np.array(times), data[:, :3], _orientation(data[:, 3:], path))
    )


def _orientation(xyzw: Floats, path: Path) -> Floats | None:
    q = np.roll(xyzw, 1, axis=1)
    norm = np.linalg.norm(q, axis=1)
    if np.all(np.abs(q[:, 1:]) < 1e-12):
        return None
    if np.any(np.abs(norm - 1) > 1e-2):
        raise Error(f"{path}: row {int(np.argmax(np.abs(norm - 1)))}: quaternion is not unit")
    return np.asarray(q / norm[:, None])


def write_tum(path: Path, trajectory: Trajectory) -> None:
    """Writes a TUM file (beside, then renamed); identity quaternions where there is no attitude."""
    q = trajectory.orientation
    if q is None:
        q = np.tile([1.0, 0.0, 0.0, 0.0], (len(trajectory), 1))
    with replacing(path) as part, part.open("w", encoding="utf-8") as file:
        for t, p, r in zip(trajectory.time, trajectory.position, q, strict=True):
            seconds, micro = divmod(int(t), 1_000_000)
            numbers = " ".join(f"{v:.9f}" for v in (*p, r[1], r[2], r[3], r[0]))
            file.write(f"{seconds}.{micro:06d} {numbers}\n")
