"""What units log, collected per instance; and the callbacks through which they log it."""

import atexit
import ctypes
import shutil
import weakref
from collections import deque
from ctypes import byref
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import fmpy
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

STATUS_NAMES = ("ok", "warning", "discard", "error", "fatal", "pending")
WARNING = 1
MESSAGES_KEPT = 1000


class Messages:
    """What one instance logged: the latest messages, and the errors that no exception has reported yet."""

    def __init__(self) -> None:
        """Nothing logged yet."""
        self.latest: deque[tuple[str, str, str]] = deque(maxlen=MESSAGES_KEPT)
        self._errors: deque[str] = deque(maxlen=MESSAGES_KEPT)

    def add(self, _environment: int | None, status: int, category: bytes | None, message: bytes | None) -> None:
        """Takes a message, as the logger of FMI 3 passes it."""
        text = (message or b"").decode("utf-8", "replace").strip()
        self.latest.append((STATUS_NAMES[status], (category or b"").decode("utf-8", "replace"), text))
        if status > WARNING:
            self._errors.append(text)

    def take_errors(self) -> str:
        """What was logged with the status discard or worse since the last call."""
        text = "; ".join(self._errors)
        self._errors.clear()
        return text


_messages_of: "weakref.WeakValueDictionary[int, Messages]" = weakref.WeakValueDictionary()


def _log_fmi2(environment: int, _name: bytes, status: int, category: bytes, message: bytes) -> None:
    messages = _messages_of.get(environment)
    if messages is not None:
        messages.add(environment, status, category, message)


# ctypes does not keep a function alive for what C holds of it.
_LOG_FMI2 = fmi2CallbackLoggerTYPE(_log_fmi2)


def fmi2_callbacks(messages: Messages) -> fmi2CallbackFunctions:
    """The callbacks of one FMI 2 instance; they must live as long as it does."""
    shared = _shared_fmi2_callbacks()
    _messages_of[id(messages)] = messages
    return fmi2CallbackFunctions(
        shared.logger, shared.allocateMemory, shared.freeMemory, componentEnvironment=id(messages)
    )


@cache
def _shared_fmi2_callbacks() -> fmi2CallbackFunctions:
    """FMI 2 logs printf style. FMPy's small library formats that, but for a single logger per process: a copy of it,
    which no one else sets, sends all to `_log_fmi2`, where the environment tells the instances apart."""
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = _LOG_FMI2
    callbacks.allocateMemory = ctypes.cast(fmpy.calloc, type(callbacks.allocateMemory))
    callbacks.freeMemory = ctypes.cast(fmpy.free, type(callbacks.freeMemory))
    original = Path(fmpy.__file__).parent / "logging" / fmpy.platform / f"logging{fmpy.sharedLibraryExtension}"
    if original.exists():
        folder = mkdtemp(prefix="ulna-logging-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        ctypes.CDLL(shutil.copy(original, folder)).addLoggerProxy(byref(callbacks))
    return callbacks
