"""All items of a study: those with a kept result are done; the others are computed in chunks of about a second."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final

from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.running.executors.executor import Executor
from cablewright.running.executors.stored_results import KeptResults
from cablewright.running.executors.task import Chunk, Outcome, Task, digest, faults, programs

CHUNK_TIME: Final = 1.0  # s
MAX_ITEMS = 5000  # of a chunk


def evaluate(
    task: Task,
    items: Sequence[Any],
    executor: Executor,
    kept: KeptResults,
    progress: Progress | None = None,
) -> tuple[Outcome, ...]:
    """Compute all items of a study, in parallel if the executor does so, and return the outcome of each.

    An item that fails has an `Outcome` with its fault, and does not stop the others. Results are added to *kept* chunk
    by chunk; faults are not, so that another call tries them again. Raises `EnvironmentFault` where no worker is
    available, or the results cannot be written.
    """
    report, stage = progress or silent, f"{task.noun}s"
    key = task.key()
    keys = [digest([key, item]) for item in items]
    known = {number: text for number, key in enumerate(keys) if (text := kept.get(key)) is not None}
    kept.tell_unused()
    done = {number: Outcome(text) for number, text in known.items()}
    left = [number for number in range(len(items)) if number not in done]
    chunks = _Chunks(task, key, items, left, executor.workers)
    report(stage, len(done), len(items))
    for computed in executor.run(chunks):
        chunks.took(len(computed.numbers), computed.seconds)
        new = dict(zip(computed.numbers, computed.outcomes, strict=True))
        kept.add({keys[number]: each.text for number, each in new.items() if not each.fault})
        done |= new
        report(stage, len(done), len(items))
    return tuple(done[number] for number in range(len(items)))


def require_all(outcomes: Sequence[Outcome], names: Sequence[str]) -> None:
    """Raise `AnswerError`, which names the first item without a result, how many there are and that others are kept.

    Raises `InputError` where all items are rejected: the input is wrong, not an item.
    """
    failed = faults(outcomes)
    if not failed:
        return
    if all(each.refused for each in outcomes):
        raise InputError(failed[0])
    first = next(name for name, each in zip(names, outcomes, strict=True) if each.fault)
    kept = len(outcomes) - len(failed)
    raise AnswerError(f"{first}: {failed[0]} ({len(failed)} of {len(outcomes)} failed; the other {kept} are kept)")


def shared_blocks(
    function: Callable[[Any, Any], Any],
    question: Any,
    blocks: Mapping[int, Any],
    executor: Executor,
    kept: KeptResults,
    progress: Progress | None = None,
) -> list[Any]:
    """Return the results of *function* on a *question* for *blocks* of positions, by the first position of each.

    Raises `AnswerError` for a block that fails, `EnvironmentFault` where no worker is available.
    """
    found = evaluate(Task(function, question, "block of places"), list(blocks.values()), executor, kept, progress)
    require_all(found, [f"places from {first + 1} on" for first in blocks])
    return [each.value for each in found]


class _Chunks:
    """The chunks of the remaining items, sized by the time that earlier chunks took."""

    def __init__(self, task: Task, key: str, items: Sequence[Any], left: Sequence[int], workers: int) -> None:
        self._task, self._key, self._items, self._left, self._workers = task, key, items, list(left), workers
        self._size = 1

    def took(self, count: int, seconds: float) -> None:
        """Choose the size of the next chunks from the duration of a finished one."""
        if seconds > 0.0:
            self._size = min(MAX_ITEMS, max(1, math.floor(CHUNK_TIME * count / seconds)))

    def __iter__(self) -> Iterator[Chunk]:
        own, first = programs(), 0
        while first < len(self._left):
            share = math.ceil((len(self._left) - first) / self._workers)  # so that workers finish together
            numbers = tuple(self._left[first : first + min(self._size, share)])
            first += len(numbers)
            yield Chunk(self._task, self._key, own, tuple(self._items[number] for number in numbers), numbers)
