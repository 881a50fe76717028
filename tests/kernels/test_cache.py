"""The kernels' disk cache: never a stale number, and nothing that a kill, a fault or a stranger can break.

Some tests compile a kernel of the package again, into a folder of their own. The others need sources to edit: a small
package of the same name, with the same `kernels/__init__.py` and `cache.py`, and processes of their own.
"""

from __future__ import annotations

import errno
import logging
import os
import pickle
import time
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core import config
from numba.core.serialize import dumps

from cablewright.kernels import cache, is_compiled, jit
from cablewright.kernels.statics import platform
from kernel_tree import DOUBLE, edit, ended, entries, planted, start

POSE = np.array([0.0, 0.0, 0.0, 2.0, 3.0, 6.0])
ANGLE = 7.0
posix = pytest.mark.skipif(os.name != "posix", reason="owners, modes, forks and signals of POSIX")


def fresh() -> Any:
    """A kernel of the package as a new process has it: not compiled yet."""
    return jit(platform.angle_of.py_func)


def hits(kernel: Any) -> int:
    """How many signatures of *kernel* came from the cache."""
    return sum(kernel.stats.cache_hits.values())


@pytest.fixture
def folder(tmp_path: Path, monkeypatch) -> Path:
    """Where the package's entries go during this test."""
    monkeypatch.setenv(cache.DIRECTORY, str(tmp_path))
    monkeypatch.setattr(cache, "_has_warned", False)
    return tmp_path / "kernels" / cache.STAMP


def test_a_kernel_is_compiled_once(folder: Path) -> None:
    first, second = fresh(), fresh()
    assert not is_compiled(first, POSE)
    assert first(POSE) == ANGLE
    assert is_compiled(second, POSE)
    assert second(POSE) == ANGLE
    assert (hits(first), hits(second)) == (0, 1)
    assert [file.parent.name for file in entries(folder)] == [f"{platform.__name__}.angle_of"]


def flipped(place: int) -> Callable[[bytes], bytes]:
    return lambda whole: whole[:place] + bytes([whole[place] ^ 16]) + whole[place:][1:]


def forged(payload: bytes) -> Callable[[bytes], bytes]:
    return lambda _whole: sha256(payload).digest() + payload


def renamed(whole: bytes) -> bytes:
    """What is whole, but was compiled from something else."""
    (_, *key), data = pickle.loads(whole[32:])
    return forged(dumps((("another stamp", *key), data)))(whole)


@pytest.mark.parametrize(
    "damage",
    [
        lambda whole: b"",
        lambda whole: whole[:20],
        lambda whole: whole[:32],
        lambda whole: whole[:-1],
        lambda whole: whole + b"\0",
        *map(flipped, (0, 31, 32, 3000, -1)),
        forged(b""),
        forged(b"cnowhere\nnothing\n."),
        renamed,
    ],
)
def test_a_damaged_entry_is_compiled_again_and_overwritten(folder: Path, caplog, damage) -> None:
    fresh()(POSE)
    (file,) = entries(folder)
    file.write_bytes(damage(file.read_bytes()))
    second, third = fresh(), fresh()
    with caplog.at_level(logging.INFO):
        assert second(POSE) == third(POSE) == ANGLE
    assert (hits(second), hits(third)) == (0, 1)
    assert entries(folder) == [file]
    assert not caplog.messages


def full_disk(folder: Path, monkeypatch) -> None:
    folder.mkdir(parents=True)
    monkeypatch.setattr(cache.Path, "replace", raising(OSError(errno.ENOSPC, "No space left on device")))


def raising(error: Exception) -> Callable[..., None]:
    def call(*_arguments: object) -> None:
        raise error

    return call


def no_folder(folder: Path, monkeypatch) -> None:
    folder.parent.write_text("a file stands where the folder should")


def no_home(folder: Path, monkeypatch) -> None:
    monkeypatch.setenv(cache.DIRECTORY, "~nobody-of-this-name")


def relative(folder: Path, monkeypatch) -> None:
    monkeypatch.setenv(cache.DIRECTORY, "here")


def group_may_write(folder: Path, monkeypatch) -> None:
    folder.mkdir(parents=True)
    folder.chmod(0o770)


def all_may_write_above(folder: Path, monkeypatch) -> None:
    folder.mkdir(parents=True)
    folder.parent.chmod(0o777)


def link(folder: Path, monkeypatch) -> None:
    folder.parent.mkdir()
    (folder.parent / "elsewhere").mkdir(0o700)
    folder.symlink_to(folder.parent / "elsewhere")


def strangers(folder: Path, monkeypatch) -> None:
    folder.mkdir(parents=True)
    own = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: own + 1)


TROUBLES = [full_disk, no_folder, no_home, relative, group_may_write, all_may_write_above, link, strangers]


@posix
@pytest.mark.parametrize("trouble", TROUBLES)
def test_without_a_folder_that_is_safe_and_writable_one_line_is_said(
    folder: Path, monkeypatch, caplog, trouble
) -> None:
    trouble(folder, monkeypatch)
    kernel = [fresh(), fresh()]
    assert [each(POSE) for each in kernel] == [ANGLE, ANGLE]
    assert sum(map(hits, kernel)) == 0
    assert not is_compiled(fresh(), POSE)
    (said,) = caplog.messages
    assert "compiled again in each process" in said
    assert not entries(folder)


@posix
def test_the_folder_is_private(folder: Path) -> None:
    fresh()(POSE)
    for each in (folder.parent, folder, *folder.rglob("*")):
        assert each.stat().st_mode & 0o077 == 0


def test_only_what_the_stamp_covers_is_kept(folder: Path) -> None:
    inner = platform.angle_of.py_func

    def closure(pose):
        return fresh_inner(pose)

    fresh_inner = jit(inner)
    outside = jit(lambda pose: 2.0 * pose[0])
    assert (outside(POSE), jit(closure)(POSE)) == (0.0, ANGLE)
    assert not entries(folder)  # the kernel that the closure calls is but a part of it


def test_what_numba_compiles_differently_has_another_stamp(monkeypatch) -> None:
    with monkeypatch.context() as changed:
        changed.setattr(config, "BOUNDSCHECK", 1)
        assert cache.stamp() != cache.STAMP
    monkeypatch.setattr(config, "THREADING_LAYER", "workqueue")
    assert cache.stamp() == cache.STAMP


def test_folders_long_unused_go_when_a_new_one_is_made(folder: Path) -> None:
    home, now = folder.parent, time.time()
    ages = {f"{i:032x}": 60.0 * i for i in range(20)} | {f"{i:032x}": 86400.0 * i for i in range(20, 40)}
    for name, age in (ages | {"not-ours": 9e7}).items():
        (home / name).mkdir(parents=True)
        (home / name / "entry").touch()
        os.utime(home / name, (now - age, now - age))
    fresh()(POSE)
    young = {name for name, age in ages.items() if age < 3600.0}
    assert {each.name for each in home.iterdir()} == young | {"not-ours", folder.name}


def test_the_newest_folders_stay_for_a_month_and_use_keeps_them_new(folder: Path) -> None:
    home, now = folder.parent, time.time()
    for i in range(20):
        (home / f"{i:032x}").mkdir(parents=True)
        os.utime(home / f"{i:032x}", (now - 86400.0 * (i + 25.5),) * 2)
    fresh()(POSE)
    assert {each.name for each in home.iterdir()} == {f"{i:032x}" for i in range(5)} | {folder.name}
    os.utime(folder, (0.0, 0.0))
    fresh()(POSE)
    assert folder.stat().st_mtime > now - 60.0


# --- Processes over sources that can be edited


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    return planted(tmp_path)


def test_an_edit_of_a_callee_in_another_folder_is_seen(tree: Path) -> None:
    """The trap of Numba's own cache; and what was compiled before the edit is found again after its undoing."""
    for rate, found in ((1.0, "2.0 0"), (1.0, "2.0 1"), (5.0, "10.0 0"), (1.0, "2.0 1")):
        edit(tree, rate)
        assert ended(start(tree, DOUBLE)) == found


def test_a_process_that_saw_an_edit_keeps_nothing(tree: Path) -> None:
    """It imported the package before the edit and the callee after it: what it compiles is of neither text."""
    process = start(tree, "import cablewright.kernels; print(flush=True); input();" + DOUBLE)
    assert process.stdout is not None
    process.stdout.readline()
    edit(tree, 5.0)
    assert ended(process, answered="\n") == "10.0 0"
    edit(tree, 1.0)
    assert ended(start(tree, DOUBLE)) == "2.0 0"


MEETING = """
import os, time
from pathlib import Path
move = Path.replace
def meet(self, target):
    Path(f"{os.getpid()}.{target.name}").touch()
    while len(list(Path().glob(f"*.{target.name}"))) < 2:
        time.sleep(0.01)
    move(self, target)
Path.replace = meet
"""


def test_two_processes_may_write_the_same_simultaneously(tree: Path) -> None:
    """Neither moves an entry to its place before both have compiled and written it."""
    both = [start(tree, MEETING + DOUBLE) for _ in range(2)]
    assert [ended(each) for each in both] == ["2.0 0", "2.0 0"]
    assert ended(start(tree, DOUBLE)) == "2.0 1"


def test_an_address_of_a_process_is_not_kept(tree: Path) -> None:
    code = "import warnings; warnings.simplefilter('error');" + DOUBLE.replace(
        "double(), hits(double)", "from_table(3)"
    )
    process = start(tree, code)
    _, err = process.communicate(timeout=120)
    assert "from_table cannot be cached" in err
    assert not list(tree.glob("cache/kernels/*/*from_table/*"))


@posix
def test_no_folder_for_many_kernels_is_one_line_on_stderr(tree: Path) -> None:
    (tree / "file").touch()
    said = "kernels are compiled again in each process"
    assert ended(start(tree, DOUBLE, folder="file"), said) == "2.0 0"


@posix
def test_a_full_disk_is_one_line_on_stderr_and_leaves_nothing(tree: Path) -> None:
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096));"
    assert ended(start(tree, full + DOUBLE), "kernels are compiled again in each process") == "2.0 0"
    assert not entries(tree / "cache")


KILLED = """
import itertools, os, resource, shutil, signal, sys, traceback
import numba
from cablewright.kernels.caller import hits, rate
numba.njit(lambda: 1.0)()  # what the first compilation of a process takes, its children need not pay

def child(home, work):
    os.environ["CABLEWRIGHT_CACHE_DIR"] = home
    number = os.fork()
    if number:
        return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
    try:
        work(home)
    except BaseException:
        traceback.print_exc()
        os._exit(1)
    os._exit(0)

def killed_at(step):
    def work(home):
        touches = itertools.count()
        def hook(event, arguments):
            if any(str(each).startswith(home) for each in arguments) and next(touches) == step:
                os.kill(os.getpid(), signal.SIGKILL)
        sys.addaudithook(hook)
        rate()
    return work

def killed_in_writing(home):
    signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
    rate()

def next_one(home):
    assert rate() == 5.0

def one_more(home):
    assert (rate(), hits(rate)) == (5.0, 1)

def tried(name, work):
    home = os.path.join(os.getcwd(), name)
    shutil.copytree("cache", home)
    status = child(home, work)
    assert child(home, next_one) == child(home, one_more) == 0
    return status

assert tried("written", killed_in_writing) == -signal.SIGXFSZ
for step in itertools.count():
    status = tried(str(step), killed_at(step))
    if status == 0:
        break
    assert status == -signal.SIGKILL
print(step)
"""


@posix
def test_a_kill_at_any_step_of_the_writing_leaves_no_wrong_number(tree: Path) -> None:
    """After an edit: neither the old number comes back, nor is what the killed process left behind believed."""
    assert ended(start(tree, DOUBLE)) == "2.0 0"  # which keeps the callee too
    edit(tree, 5.0)
    steps = int(ended(start(tree, KILLED)))
    assert steps >= 5  # two folders are made, the entry is made, opened for writing, and moved
