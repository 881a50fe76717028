"""What the command `cablewright` and `python -m cablewright` start.

The application takes a while to import. Whoever asks it to end before it can answer finds it gone, without a traceback.
"""

import os
import signal

INTERRUPTED = 130


def main() -> None:
    """Run the command line of this process."""
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _leave)
    from cablewright.apps.cli.main import main as application

    application()


def _leave(_number: int, _frame: object) -> None:
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
