"""Work for executors under test: functions that worker processes can import."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

from cablewright.foundation.errors import AnswerError


def numbers(shared: dict[str, Any], item: int) -> dict[str, float]:
    """Some arithmetic that rounds; item 7 has no answer, and item 8 no arithmetic."""
    if item == 7:
        raise AnswerError("seven has no answer")
    if item == 8:
        return {"quotient": 1.0 / (item - 8)}
    time.sleep(shared.get("pause", 0.0))
    return {"third": item / 3.0, "root": item**0.5 * shared["factor"], "none": float("nan")}


def deadly(shared: str, item: int) -> int:
    """Item 3 kills its worker: always, or where *shared* names a file, once."""
    if item == 3:
        if not shared or not Path(shared).exists():
            if shared:
                Path(shared).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return -3
    return item
