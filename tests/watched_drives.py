"""Virtual drives in this process by wall clock, for hosts in processes of their own."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from cablewright.machine.drives.cia402 import PowerState
from cablewright.machine.drives.loopback import Hub
from cablewright.machine.drives.virtual.rig import VirtualRig, run_rig
from cablewright.machine.simulated.settings import load_twin
from cablewright.robot import load
from virtual_drives import RING_BEGIN, virtual_twin

EXAMPLE = Path(__file__).parents[1] / "examples" / "virtual-drives.toml"


@dataclass
class Watched:
    """Drives in this process, on a thread, and what their plant showed."""

    rig: VirtualRig
    channel: int
    tensions: list[float] = field(default_factory=list)

    @property
    def braked(self) -> bool:
        """Whether all brakes are closed."""
        return all(drive.brake_closed for drive in self.rig.drives)

    def wait(self, what: str, seconds: float = 10.0) -> None:
        """Wait until all drives are in a state, by its name."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if all(drive.state is PowerState[what] for drive in self.rig.drives):
                return
            time.sleep(0.005)
        raise AssertionError([drive.state for drive in self.rig.drives])


@contextmanager
def watched_drives(file: Path | None = None) -> Iterator[Watched]:
    """Drives of merlet2023 on a thread, until the end: those of `virtual_twin`, or of the example written to *file*."""
    robot, over, hub = load("merlet2023"), threading.Event(), Hub(0)
    channel = hub._socket.getsockname()[1]
    if file is not None:
        file.write_text(EXAMPLE.read_text("utf-8").replace('"43113"', f'"{channel}"'), encoding="utf-8")
    rig = VirtualRig(robot, virtual_twin() if file is None else load_twin(file), RING_BEGIN["merlet2023"])
    rig.warm()
    found = Watched(rig, channel)

    def ends() -> bool:
        found.tensions.append(float(rig.plant.truth.tensions.max()))
        return over.is_set()

    thread = threading.Thread(target=run_rig, args=(rig, hub, ends), daemon=True)
    thread.start()
    try:
        yield found
    finally:
        over.set()
        thread.join(timeout=10.0)
        hub.close()
