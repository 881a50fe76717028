"""What the command `cablewright` and `python -m cablewright` start.

The application takes a while to import. Whoever asks it to end before it can answer finds it gone, without a traceback.
"""

from __future__ import annotations

import os
import signal

INTERRUPTED = 130


def limit_threads() -> None:
    """Limit NumPy's libraries to one thread, unless the user has set a number. Call this before NumPy is imported.

    Our matrices are small: several threads would mostly wait for each other.
    """
    if "OMP_NUM_THREADS" not in os.environ:  # which OpenBLAS reads too
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        os.environ.setdefault("VECLIB_MAXIMUM_THREADS", "1")


def main() -> None:
    """Run the command line of this process."""
    limit_threads()
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _leave)
    from cablewright.apps.cli.main import main as application

    application()


def _leave(_number: int, _frame: object) -> None:
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
