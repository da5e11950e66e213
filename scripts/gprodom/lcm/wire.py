"""LCM messages of one type as numpy arrays, encoded and decoded all at once.

The generated classes handle one message at a time; a log holds hundreds of thousands. The layouts
here restate those of ``lcmtypes/*.lcm``, in its words, for the types that come often; a test
compares them with the generated classes. LCM is big-endian and packed: fingerprint, then the fields
in order.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from gprodom.errors import Error
from gprodom.lcm.messages import fingerprint

Arrays = dict[str, npt.NDArray[np.generic]]

# Name, type, shape. An empty type is a string; a shape that is a name is an array whose length
# stands in the field of that name. At most one such field a type.
Field = tuple[str, str, tuple[int, ...] | str]

_INTEGERS = {"boolean": ">i1", "int8_t": ">i1", "int32_t": ">i4", "int64_t": ">i8"}
_TYPES = {**_INTEGERS, "double": ">f8", "string": ""}


def _field(declaration: str) -> Field:
    kind, _, name = declaration.partition(" ")
    name, _, length = name.removesuffix("]").partition("[")
    shape = (int(length),) if length.isdigit() else length
    return name, _TYPES[kind], shape or ()


LAYOUTS: dict[str, list[Field]] = {
    name: [_field(declaration) for declaration in declarations.split("; ")]
    for name, declarations in {
        "gpr_trace_t": "int64_t utime; int64_t seq; int32_t antenna_id; double sample_interval; "
        "double time_zero; double volts_per_count; int32_t num_samples; "
        "int32_t samples[num_samples]",
        "imu_t": "int64_t utime; double linear_acceleration[3]; double angular_velocity[3]; "
        "boolean has_orientation; double orientation[4]",
        "wheel_t": "int64_t utime; int64_t ticks; double metres_per_tick",
        "wheels_t": "int64_t utime; int64_t left_ticks; int64_t right_ticks; "
        "double metres_per_tick",
        "position_truth_t": "int64_t utime; double position[3]",
        "position_fix_t": "int64_t utime; int8_t frame; double position[3]; double covariance[9]; "
        "int8_t quality; int32_t antenna_id; boolean has_heading; double heading; "
        "double heading_sigma",
        "displacement_t": "int64_t utime; int64_t utime_from; int64_t utime_to; string source; "
        "int8_t kind; boolean valid; double distance; double sigma; double lateral; "
        "double lateral_sigma; boolean mirrored; double scale; double score",
        "odometry_t": "int64_t utime; string frame; double position[3]; double orientation[4]; "
        "double velocity[3]; double angular_velocity[3]; double pose_covariance[36]; "
        "double velocity_covariance[9]; double gyro_bias[3]; double accel_bias[3]; "
        "double wheel_scale; double wheel_scale_sigma; double distance; int32_t flags",
        "correction_t": "int64_t utime; double position[3]; double orientation[4]; "
        "int32_t revisits; double covariance[36]",
    }.items()
}

_BOOLEANS = ("has_orientation", "has_heading", "valid", "mirrored")
_LENGTH = "length of "  # prefixes the name of a string's length field


def _dtype(name: str, extent: int) -> np.dtype[np.void]:
    """The message's layout; its one string or array of variable length takes `extent` elements."""
    fields: list[tuple[str, str, tuple[int, ...]]] = [("fingerprint", "V8", ())]
    for field, kind, shape in LAYOUTS[name]:
        if kind == "":
            fields.append((_LENGTH + field, ">i4", ()))
            fields.append((field, f"S{extent}", ()))
        elif isinstance(shape, str):
            fields.append((field, kind, (extent,)))
        else:
            fields.append((field, kind, shape))
    return np.dtype(fields)


def _extent(name: str, size: int) -> int:
    """How many elements the variable field has in a message of `size` bytes; -1: none fits."""
    with_one = _dtype(name, 1).itemsize
    for _, kind, shape in LAYOUTS[name]:
        if kind == "" or isinstance(shape, str):
            element = 1 if kind == "" else np.dtype(kind).itemsize
            more, left = divmod(size - with_one, element)
            least = 1 if kind == "" else 0  # a string has its zero byte
            return 1 + more if left == 0 and 1 + more >= least else -1
    return 0 if size == with_one else -1


def encode(name: str, arrays: Mapping[str, npt.ArrayLike], count: int) -> list[bytes]:
    """`count` messages of type `name`. Each field: one value for all or one per message.

    Types with a string cannot be encoded; a variable array is (count, n).
    """
    extent = 0
    for field, _, shape in LAYOUTS[name]:
        if isinstance(shape, str):
            extent = np.shape(arrays[field])[-1]
            arrays = {**arrays, shape: extent}
    dtype = _dtype(name, extent)
    table = np.zeros(count, dtype)
    table["fingerprint"] = np.void(fingerprint(name))
    for field, _, _ in LAYOUTS[name]:
        table[field] = arrays[field]
    data, size = table.tobytes(), dtype.itemsize
    return [data[start : start + size] for start in range(0, count * size, size)]


def decode(name: str, payloads: Sequence[bytes], where: str) -> Arrays:
    """The fields of `payloads`, messages of type `name`, each as an array with one row a message.

    Booleans are bool, strings str; arrays of differing lengths make an object array. Raises `Error`
    beginning with `where` on a message of impossible length.
    """
    sizes = np.array([len(payload) for payload in payloads])
    result: Arrays = {}
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size)
        extent = _extent(name, int(size))
        if extent < 0:
            raise Error(f"{where}: message {rows[0]} has {size} bytes, as no {name} can")
        data = b"".join(payloads[row] for row in rows.tolist())
        table = np.frombuffer(data, _dtype(name, extent))
        for field, kind, shape in LAYOUTS[name]:
            column = _column(table, field, kind)
            if len(rows) == len(payloads):
                result[field] = column
                continue
            ragged = kind == "" or isinstance(shape, str)
            if field not in result:
                whole = np.empty((len(payloads), *column.shape[1:]), column.dtype)
                result[field] = np.empty(len(payloads), object) if ragged else whole
            for row, value in zip(rows, column, strict=True):
                result[field][row] = value
    return result


def _column(table: npt.NDArray[np.void], field: str, kind: str) -> npt.NDArray[np.generic]:
    if kind == "":  # ends with a zero byte, which numpy drops
        return np.char.decode(table[field], "utf-8", "replace")
    column: npt.NDArray[np.generic] = table[field].astype(np.dtype(kind).newbyteorder("="))
    return column.astype(bool) if field in _BOOLEANS else column
