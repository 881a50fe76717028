"""What the command `cablewright` and `python -m cablewright` start.

The application takes a while to import. Whoever asks it to end before it can answer finds it gone, without a traceback.
"""

from __future__ import annotations

import os
import signal

INTERRUPTED = 130
SMALL_MATRICES = {"OPENBLAS_NUM_THREADS": "1", "VECLIB_MAXIMUM_THREADS": "1"}
"""Threads of NumPy's libraries, unless the user sets them: for our matrices they mostly wait for each other."""


def main() -> None:
    """Run the command line of this process."""
    if "OMP_NUM_THREADS" not in os.environ:  # which says it for all
        for name, threads in SMALL_MATRICES.items():
            os.environ.setdefault(name, threads)
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _leave)
    from cablewright.apps.cli.main import main as application

    application()


def _leave(_number: int, _frame: object) -> None:
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
