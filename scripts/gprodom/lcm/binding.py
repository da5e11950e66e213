"""A thin binding over Debian's liblcm.so.1 with the API of the PyPI module ``lcm``.

Covers what `gprodom.lcm` exports: `LCM`, `LCMSubscription`, `EventLog`, `Event`.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterator
from os import PathLike

from gprodom.errors import Error

Handler = Callable[[str, bytes], None]


class _ReceiveBuffer(ctypes.Structure):
    _fields_ = [
        ("data", ctypes.c_void_p),
        ("data_size", ctypes.c_uint32),
        ("recv_utime", ctypes.c_int64),
        ("lcm", ctypes.c_void_p),
    ]


class _CEvent(ctypes.Structure):
    _fields_ = [
        ("eventnum", ctypes.c_int64),
        ("timestamp", ctypes.c_int64),
        ("channellen", ctypes.c_int32),
        ("datalen", ctypes.c_int32),
        ("channel", ctypes.c_void_p),
        ("data", ctypes.c_void_p),
    ]


class _CEventLog(ctypes.Structure):
    _fields_ = [("file", ctypes.c_void_p), ("eventcount", ctypes.c_int64)]


_HANDLER = ctypes.CFUNCTYPE(None, ctypes.POINTER(_ReceiveBuffer), ctypes.c_char_p, ctypes.c_void_p)


def _load(name: str, signatures: dict[str, tuple[object, list[object]]]) -> ctypes.CDLL:
    try:
        library = ctypes.CDLL(name, use_errno=True)
    except OSError:
        raise Error(f"cannot load {name}: install the Debian package liblcm1") from None
    for function, (result, arguments) in signatures.items():
        getattr(library, function).restype = result
        getattr(library, function).argtypes = arguments
    return library


_p, _int, _i64, _str = ctypes.c_void_p, ctypes.c_int, ctypes.c_int64, ctypes.c_char_p
_event_p, _log_p = ctypes.POINTER(_CEvent), ctypes.POINTER(_CEventLog)

_lcm = _load(
    "liblcm.so.1",
    {
        "lcm_create": (_p, [_str]),
        "lcm_destroy": (None, [_p]),
        "lcm_get_fileno": (_int, [_p]),
        "lcm_subscribe": (_p, [_p, _str, _HANDLER, _p]),
        "lcm_unsubscribe": (_int, [_p, _p]),
        "lcm_publish": (_int, [_p, _str, _str, ctypes.c_uint]),
        "lcm_handle": (_int, [_p]),
        "lcm_handle_timeout": (_int, [_p, _int]),
        "lcm_subscription_set_queue_capacity": (_int, [_p, _int]),
        "lcm_eventlog_create": (_log_p, [_str, _str]),
        "lcm_eventlog_destroy": (None, [_log_p]),
        "lcm_eventlog_read_next_event": (_event_p, [_log_p]),
        "lcm_eventlog_free_event": (None, [_event_p]),
        "lcm_eventlog_seek_to_timestamp": (_int, [_log_p, _i64]),
        "lcm_eventlog_write_event": (_int, [_log_p, _event_p]),
    },
)
_libc = _load("libc.so.6", {"fseeko": (_int, [_p, _i64, _int]), "ftello": (_i64, [_p])})


class LCMSubscription:
    """The result of `LCM.subscribe`."""

    def __init__(self) -> None:
        self._pointer: int | None = None
        self._callback: object = None  # keeps the C thunk alive as long as liblcm may call it

    def set_queue_capacity(self, num_messages: int) -> None:
        """How many received messages may wait; 0 for no limit."""
        _lcm.lcm_subscription_set_queue_capacity(self._pointer, num_messages)


class LCM:
    """One LCM connection. `provider`: a URL such as ``udpm://239.255.76.67:7667?ttl=0``."""

    def __init__(self, provider: str | None = None) -> None:
        self._pointer = _lcm.lcm_create(provider.encode() if provider is not None else None)
        if not self._pointer:
            raise RuntimeError("Couldn't create LCM")
        self._subscriptions: list[LCMSubscription] = []
        self._raised: BaseException | None = None

    def __del__(self) -> None:
        if getattr(self, "_pointer", None):
            _lcm.lcm_destroy(self._pointer)
            self._pointer = None

    def publish(self, channel: str, data: bytes) -> None:
        """Sends `data` on `channel`."""
        if _lcm.lcm_publish(self._pointer, channel.encode(), data, len(data)) != 0:
            raise OSError(f"cannot publish {len(data)} bytes on {channel}")

    def subscribe(self, channel: str, callback: Handler) -> LCMSubscription:
        """Calls ``callback(channel, data)`` for messages on `channel`, a regular expression."""

        def receive(buffer: ctypes._Pointer[_ReceiveBuffer], name: bytes, _user: object) -> None:
            content = buffer.contents
            try:
                callback(name.decode(), ctypes.string_at(content.data, content.data_size))
            except BaseException as error:  # cannot pass through C; handle() raises it
                self._raised = error

        subscription = LCMSubscription()
        thunk = _HANDLER(receive)
        subscription._callback = thunk
        subscription._pointer = _lcm.lcm_subscribe(self._pointer, channel.encode(), thunk, None)
        if not subscription._pointer:
            raise RuntimeError(f"cannot subscribe to {channel!r}")
        self._subscriptions.append(subscription)
        return subscription

    def unsubscribe(self, subscription_object: LCMSubscription) -> None:
        """Ends a subscription."""
        if subscription_object not in self._subscriptions:
            raise ValueError("not a subscription of this LCM")
        _lcm.lcm_unsubscribe(self._pointer, subscription_object._pointer)
        self._subscriptions.remove(subscription_object)
        subscription_object._pointer = None

    def handle(self) -> None:
        """Waits for one message and dispatches it. OSError at the end of a ``file://`` log."""
        status = _lcm.lcm_handle(self._pointer)
        self._raise_from_callback()
        if status < 0:
            raise OSError("lcm_handle() returned -1")

    def handle_timeout(self, timeout_millis: int) -> int:
        """The same with a time limit; 0 if no message arrived in time, otherwise positive."""
        if timeout_millis < 0:
            raise ValueError("invalid timeout")
        status = _lcm.lcm_handle_timeout(self._pointer, timeout_millis)
        self._raise_from_callback()
        if status < 0:
            raise OSError("lcm_handle_timeout() returned -1")
        return int(status)

    def fileno(self) -> int:
        """A descriptor that select() finds readable when a message waits."""
        return int(_lcm.lcm_get_fileno(self._pointer))

    def _raise_from_callback(self) -> None:
        if self._raised is not None:
            error, self._raised = self._raised, None
            raise error


class Event:
    """One message of a log. `timestamp`: microseconds since 1970."""

    def __init__(self, eventnum: int, timestamp: int, channel: str, data: bytes) -> None:
        self.eventnum = eventnum
        self.timestamp = timestamp
        self.channel = channel
        self.data = data


class EventLog:
    """An LCM log file, for reading (``r``) or writing (``w``)."""

    def __init__(self, path: str | PathLike[str], mode: str = "r", overwrite: bool = False) -> None:
        self._log: ctypes._Pointer[_CEventLog] | None = None
        if mode not in ("r", "w"):
            raise ValueError("invalid event log mode")
        if mode == "w" and os.path.exists(path) and not overwrite:
            raise ValueError(
                "Refusing to overwrite existing log file unless overwrite is set to True"
            )
        self.mode = mode
        self._path = os.fspath(path)
        self._log = _lcm.lcm_eventlog_create(os.fsencode(path), mode.encode())
        if not self._log:
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number), self._path)

    def __del__(self) -> None:
        self.close()

    def close(self) -> None:
        """Flushes and closes; harmless when repeated."""
        if self._log:
            _lcm.lcm_eventlog_destroy(self._log)
            self._log = None

    def read_next_event(self) -> Event | None:
        """The next event; None at the end."""
        pointer = _lcm.lcm_eventlog_read_next_event(self._open("r"))
        if not pointer:
            return None
        event = pointer.contents
        result = Event(
            event.eventnum,
            event.timestamp,
            ctypes.string_at(event.channel, event.channellen).decode(),
            ctypes.string_at(event.data, event.datalen),
        )
        _lcm.lcm_eventlog_free_event(pointer)
        return result

    def write_event(self, utime: int, channel: str, data: bytes) -> None:
        """Appends a message. `utime`: microseconds since 1970."""
        name = channel.encode()
        event = _CEvent(
            timestamp=utime,
            channellen=len(name),
            datalen=len(data),
            channel=ctypes.cast(ctypes.c_char_p(name), ctypes.c_void_p),
            data=ctypes.cast(ctypes.c_char_p(data), ctypes.c_void_p),
        )
        if _lcm.lcm_eventlog_write_event(self._open("w"), ctypes.byref(event)) != 0:
            raise OSError(f"cannot write to {self._path}")

    def __iter__(self) -> Iterator[Event]:
        """Iterates from the start."""
        self.seek(0)
        return self

    def __next__(self) -> Event:
        event = self.read_next_event()
        if event is None:
            raise StopIteration
        return event

    next = __next__

    def seek(self, filepos: int) -> None:
        """To the first event that starts at byte `filepos` or after."""
        _libc.fseeko(self._file(), filepos, os.SEEK_SET)

    def seek_to_timestamp(self, timestamp: int) -> None:
        """Near the first event at or after `timestamp` (microseconds since 1970)."""
        _lcm.lcm_eventlog_seek_to_timestamp(self._open("r"), timestamp)

    def tell(self) -> int:
        """The position in the file, bytes."""
        return int(_libc.ftello(self._file()))

    def size(self) -> int:
        """The size of the file, bytes."""
        here = self.tell()
        _libc.fseeko(self._file(), 0, os.SEEK_END)
        size = self.tell()
        self.seek(here)
        return size

    def _open(self, mode: str) -> ctypes._Pointer[_CEventLog]:
        if not self._log:
            raise ValueError("the event log is closed")
        if self.mode != mode:
            raise RuntimeError("wrong mode for this operation on an event log")
        return self._log

    def _file(self) -> int:
        return int(self._open(self.mode).contents.file)
