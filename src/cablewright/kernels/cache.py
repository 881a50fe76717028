"""The kernels' disk cache: one file for each compiled signature, in a folder named by the cache stamp.

The stamp is a hash of all kernel sources and of the programs that compile them, so that no edit, not even of a callee,
leads to outdated results. Files are written atomically and have a checksum, since they may be truncated or corrupted.
`docs/decisions/0003-cache-stamp.md` says why Numba's own cache is not used.
"""

import errno
import hashlib
import logging
import os
import pickle
import re
import shutil
import stat
import sys
import sysconfig
import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.errors import NumbaWarning
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs
from numba.np import linalg

from cablewright.kernels.compiler import KernelCompiler, Part
from cablewright.kernels.shipped_kernels import carried, tell_unused

DIRECTORY = "CABLEWRIGHT_CACHE_DIR"
"""Environment variable with the cache folder (default: the user's cache folder)."""
_CHECKSUM = hashlib.sha256().digest_size
_KEPT, _RECENT, _OLD = 8, 3600.0, 30 * 86400.0  # folders of other stamps; s since their last use
_IDLE = re.compile("^_|CACHE|COLOR|CPU_|CUDA|GDB|THREAD")
"""Settings of Numba that do not change the compiled code, or, as the processor, have a place in the key."""
_HOME = Path(__file__).parent
SOURCES = frozenset(_HOME.rglob("[!.]*.py"))
log = logging.getLogger(__name__)


def stamp() -> str:
    """Hash everything that a compiled kernel depends on, without its types and the CPU: programs, settings, sources.

    Of Python that is its binary interface, which all releases of a minor version share; of NumPy, as Numba sees it, the
    minor version.
    """
    interface = sysconfig.get_config_var("SOABI") or sys.version
    libraries = (np.__version__.split(".")[:2], numba.__version__, llvmlite.__version__)
    programs = (interface, sys.flags.optimize, *libraries)
    settings = [f"{name}={value}" for name, value in vars(config).items() if name.isupper() and not _IDLE.search(name)]
    digest = hashlib.sha256(repr((programs, sorted(settings))).encode())
    for file in sorted(SOURCES):
        digest.update(file.relative_to(_HOME).as_posix().encode() + b"\0")
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()[:32]


STAMP = stamp()  # before any kernel is imported


def is_stamped(function: Any) -> bool:
    """Return whether an edit of *function* changes the cache stamp: its file is hashed, and it is not a closure."""
    return Path(function.__code__.co_filename) in SOURCES and function.__closure__ is None


class KernelCache(NullCache):  # type: ignore[misc]
    """Disk cache of the compiled signatures of one *function*, with the methods that Numba's dispatchers call."""

    def __init__(self, function: Any) -> None:
        self._name = f"{function.__module__}.{function.__qualname__}"
        self._folder = re.sub(r"[^\w.]", "_", self._name)
        self._line = function.__code__.co_firstlineno

    def load_overload(self, signature: Any, target: Any) -> CompileResult | None:
        """Return the kernel compiled for *signature* by an earlier process; None if there is no valid one."""
        _load_array_functions()
        target.refresh()
        if KernelCompiler.depth:  # a part: the folder has none
            return None
        host = target.codegen().magic_tuple()
        for file, key in self._entries(signature, host):
            data = _read(file, key)
            if data is not None:
                return CompileResult._rebuild(target, *data)
        tell_unused(STAMP, host)
        return None

    def save_overload(self, signature: Any, result: CompileResult) -> None:
        """Save *result* for later processes, unless the sources have changed since this process read them."""
        if isinstance(result.entry_point, Part):
            return
        if result.library.has_dynamic_globals or not all(lifted.can_cache for lifted in result.lifted):
            warnings.warn(f"{self._name} cannot be cached: it holds addresses of this process", NumbaWarning, 2)
            return
        folder = open_folder()
        if folder is None:
            return
        key = self._key(signature, result.codegen.magic_tuple())
        try:
            if stamp() == STAMP:
                plain = result._replace(type_annotation="")  # it quotes the sources, with their place on this machine
                _write(folder / self._file(key), dumps((key, plain._reduce())))
        except OSError as reason:
            _warn_once(reason)

    def holds(self, signature: Any, codegen: Any) -> bool:
        """Return whether the function is in the cache, compiled for *signature*."""
        return any(file.exists() for file, _ in self._entries(signature, codegen.magic_tuple()))

    def _entries(self, signature: Any, host: tuple[Any, ...]) -> Iterator[tuple[Path, tuple[Any, ...]]]:
        """Where the function may be as compiled for *signature*, and as what: in the package, then in the folder."""
        found = carried(STAMP, host)
        if found is not None:
            folder, processor = found
            key = self._key(signature, processor)
            yield folder / self._file(key), key
        own = open_folder()
        if own is not None:
            key = self._key(signature, host)
            yield own / self._file(key), key

    def _key(self, signature: Any, processor: tuple[Any, ...]) -> tuple[Any, ...]:
        return STAMP, self._name, self._line, signature, processor

    def _file(self, key: tuple[Any, ...]) -> Path:
        return Path(self._folder, hashlib.sha256(repr(key).encode()).hexdigest()[:32])


@cache
def _load_array_functions() -> None:
    """Import Numba's array functions without SciPy's BLAS, which they load, for 0.15 s, to see whether it is there.

    It is: SciPy is a requirement. Whatever needs it, such as a compiled `numpy.dot`, loads it then.
    """
    found = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = found


def open_folder() -> Path | None:
    """Return the cache folder of this stamp, created if missing; None if it cannot be created or trusted.

    The reason of None is logged once.
    """
    try:
        home = Path(os.environ.get(DIRECTORY) or AppDirs("cablewright", False).user_cache_dir).expanduser()
        if not home.is_absolute():
            raise OSError(errno.EINVAL, "not an absolute path", str(home))
        kernels, folder = home / "kernels", home / "kernels" / STAMP
        is_new = not folder.exists()
        for each in (kernels, folder):
            if is_new:
                each.mkdir(0o700, parents=True, exist_ok=True)
            _refuse_shared(each)
        with suppress(OSError):  # a read-only folder is still useful, and pruning is optional
            os.utime(folder)
            if is_new:
                _prune(kernels)
    except (OSError, RuntimeError) as reason:  # RuntimeError: a user without a home
        _warn_once(reason)
        return None
    return folder


def _refuse_shared(folder: Path) -> None:
    """Raise `PermissionError` if *folder* is a link or others may write to it, since unpickling executes code."""
    found = folder.lstat()
    own = os.name != "posix" or (found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH))
    if not (own and stat.S_ISDIR(found.st_mode)):
        raise PermissionError(errno.EACCES, "others may write to this folder", str(folder))


def _prune(kernels: Path) -> None:
    """Remove folders of other stamps that are old, or that are neither recently used nor among the newest."""
    others = [each for each in kernels.iterdir() if re.fullmatch("[0-9a-f]{32}", each.name) and each.name != STAMP]
    now = time.time()
    idle = sorted((now - each.lstat().st_mtime, each) for each in others)
    for rank, (seconds, folder) in enumerate(idle):
        if seconds > _OLD or (rank >= _KEPT and seconds > _RECENT):
            shutil.rmtree(folder, ignore_errors=True)


_has_warned = False


def _warn_once(reason: Exception) -> None:
    global _has_warned
    level = logging.DEBUG if _has_warned else logging.WARNING
    log.log(level, "kernels are compiled again in each process: %s", reason)
    _has_warned = True


def _read(file: Path, key: tuple[Any, ...]) -> Any:
    """Return the data saved in *file* for *key*; None if the file is missing, damaged, or of another key."""
    try:
        content = memoryview(file.read_bytes())
        if hashlib.sha256(content[_CHECKSUM:]).digest() != content[:_CHECKSUM]:
            raise pickle.UnpicklingError("its checksum is wrong")
        found, data = pickle.loads(content[_CHECKSUM:])
    except FileNotFoundError:
        return None
    except (OSError, pickle.UnpicklingError, AttributeError, EOFError, ImportError, IndexError) as reason:
        log.debug("%s is compiled again: %s", file.name, reason)
        return None
    return data if found == key else None


def _write(file: Path, payload: bytes) -> None:
    """Write *file* atomically: a killed process leaves no partial file under this name."""
    handle, name = tempfile.mkstemp(dir=file.parents[1])
    try:
        with open(handle, "wb") as out:
            out.write(hashlib.sha256(payload).digest() + payload)
        file.parent.mkdir(0o700, exist_ok=True)
        Path(name).replace(file)
    finally:
        Path(name).unlink(missing_ok=True)  # exists only if it was not moved
