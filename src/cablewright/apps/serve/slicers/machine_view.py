"""State of the machine and of the newest upload, in the terms of Moonraker and OctoPrint."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Final

from cablewright.apps.serve.shared_state import Served
from cablewright.foundation.errors import InputError
from cablewright.foundation.units import spell_length

_OLD: Final = 2.0  # s, age from which the control's state is not that of now
_PRINT: Final = {  # states of the supervisor in a sitting with a job, in Moonraker's words
    "ready": "printing", "printing": "printing", "paused": "paused", "stopped": "paused", "refilling": "paused",
}  # fmt: skip
_FLAGS: Final = ("operational", "paused", "printing", "pausing", "cancelling", "error", "ready", "closedOrError")
_TEXTS: Final = {"printing": "Printing", "paused": "Paused", "error": "Error"}  # of OctoPrint


@dataclass(frozen=True)
class MachineView:
    """State of the machine as slicers see it.

    ``klippy``: whether the machine is open: ready, startup, shutdown. ``print_state``: standby, printing, paused,
    complete, cancelled, error. ``job``: job that is printed, or the newest upload; None where there is none.
    ``control``: the state of the control; ``path``: file of the job that is printed.
    """

    klippy: str
    print_state: str
    message: str
    job: dict[str, Any] | None
    control: dict[str, Any]
    path: dict[str, Any] | None

    @property
    def file(self) -> str:
        """File name of the present job."""
        return "" if self.job is None else self.job["file"] or self.job["name"]

    @property
    def progress(self) -> float:
        """Share of the path that is printed, 0 to 1."""
        if self.path is None:
            return 1.0 if self.print_state == "complete" else 0.0
        return min(1.0, float(self.control.get("distance", 0.0)) / max(float(self.path["length"]), 1e-9))

    @property
    def printed(self) -> float:
        """Time on the path, at the planned speed, s."""
        return float(self.control.get("path_time") or 0.0) if self.path is not None else 0.0

    @property
    def left(self) -> float | None:
        """Remaining time of the print, s; None: not known."""
        return self.control.get("left") if self.print_state == "printing" else None

    def objects(self) -> dict[str, dict[str, Any]]:
        """Return Moonraker's status objects, in mm and s."""
        control, path = self.control, self.path
        platform = control.get("platform") or {}
        known = bool(platform.get("valid"))
        position = [1e3 * v for v in (platform.get("nozzle") or platform.get("position") or (0.0,) * 3)]
        info = {"total_layer": None if path is None else path["layers"], "current_layer": control.get("layer")}
        return {
            "webhooks": {"state": self.klippy, "state_message": self.message},
            "print_stats": {
                "state": self.print_state,
                "message": self.message,
                "filename": self.file,
                "total_duration": self.printed,
                "print_duration": self.printed,
                "filament_used": 0.0,
                "info": info if path is not None else {"total_layer": None, "current_layer": None},
            },
            "virtual_sdcard": {
                "progress": self.progress,
                "is_active": self.print_state == "printing",
                "file_path": self.file or None,
                "file_size": 0 if self.job is None else self.job["bytes"],
                "file_position": 0,
            },
            "display_status": {"progress": self.progress, "message": self.message},
            "toolhead": {"position": [*position, 0.0], "homed_axes": "xyz" if known else "", "print_time": 0.0},
            "gcode_move": {"gcode_position": [*position, 0.0], "speed_factor": control.get("share", 1.0)},
            "idle_timeout": {"state": "Printing" if self.print_state == "printing" else "Idle", "printing_time": 0.0},
        }

    def flags(self) -> dict[str, Any]:
        """Return OctoPrint's state: text and flags."""
        closed, now = self.klippy != "ready", self.print_state
        true = {"closedOrError"} if closed else {"operational", now if now in _TEXTS else "ready"}
        text = "Offline" if closed else _TEXTS.get(now, "Operational")
        return {"text": text, "message": self.message, "flags": {each: each in true for each in _FLAGS}}


def verdict_of(job: dict[str, Any]) -> str:
    """Return the verdict on an upload, with the expected error, and the next step."""
    check, name = job["check"], job["file"] or job["name"]
    if job["busy"] and check is None:
        return f"{name} {'waits for its check' if job['busy'] == 'waits' else job['busy']}"
    if check is None:
        return f"{name} was not checked: check it on the page"
    if check["answer"] == "failed":
        return f"{name} could not be checked: {check['why']}"
    error = check["expected_error"]
    told = f"; expected error {spell_length(error)}" if error is not None else ""
    if check["answer"] == "no":
        return f"{name}: check says no{told}: {check['why']}"
    return f"{name}: check says yes{told}; a person starts it on the page"


def view_of(page: Served, jobs: list[dict[str, Any]]) -> MachineView:
    """Return the present state for slicers. *jobs*: all, the newest first."""
    control, sitting = page.feed.state, page.feed.sitting
    closed = not control or control.get("state") == "closed" or time.monotonic() - control.get("clock", 0.0) > _OLD
    klippy = ("startup" if control.get("opening") else "shutdown") if closed else "ready"
    loaded = sitting.get("job")
    if loaded is not None and not closed:
        job = next((each for each in jobs if each["id"] == loaded["id"]), None)
        state = str(control["state"])
        shown = _PRINT.get(state, "error" if state == "fault" and not control.get("fresh") else "standby")
        words = verdict_of(job) if shown == "standby" and job is not None else f"{state}: {control.get('reason') or ''}"
        return MachineView(klippy, shown, words.rstrip(": "), job, control, sitting.get("path"))
    newest = next((each for each in jobs if each["file"]), None)
    if closed:
        why = str(control.get("reason") or "the control does not answer")
        return MachineView(klippy, "standby", why, newest, control, None)
    ended = _ended(page, jobs)
    if ended is not None and (newest is None or ended[0]["id"] == newest["id"]):
        return MachineView(
            klippy, ended[1], f"{ended[0]['file'] or ended[0]['name']}: {ended[2]}", ended[0], control, None
        )
    return MachineView(
        klippy, "standby", "no job was sent yet" if newest is None else verdict_of(newest), newest, control, None
    )


def _ended(page: Served, jobs: list[dict[str, Any]]) -> tuple[dict[str, Any], str, str] | None:
    """Job, state and words of the last run, where that has ended and its job is there."""
    for run in page.uploads.runs({}, 1):
        try:
            number = page.uploads.job_of_run(run["name"])
        except InputError:
            continue
        job = next((each for each in jobs if each["id"] == number), None)
        if job is not None and run["late"]["counts"] is not None:
            shown = {"finished": "complete", "fault": "error"}.get(run["status"], "cancelled")
            return job, shown, f"{run['status']}{': ' + run['reason'] if run['reason'] else ''}"
    return None
