"""Detection of news of a print (layers, pauses, faults, ends) between two states of a machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from cablewright.apps.serve.notices.settings import NewsKind
from cablewright.foundation.signals import PrintState

_PAUSES: Final = (PrintState.PAUSED, PrintState.STOPPED, PrintState.REFILLING)
_ENDS: Final = " ends: "  # in the event of a run

News = dict[str, Any]


@dataclass(eq=False)
class NewsWatch:
    """Compares successive states of a machine; states may be missing in between."""

    _state: str = ""
    _layer: int = -1
    _event: int | None = None  # number of the last one that was seen; None: those from before do not count
    _sitting: int = -1

    def look(self, control: dict[str, Any], sitting: dict[str, Any]) -> list[News]:
        """Return the news in the state *control* of a *sitting*."""
        if not control.get("sitting"):
            return []
        happened = self._ended(control)
        state, layer = control["state"], control.get("layer", -1)
        if control["sitting"] != self._sitting:
            self._sitting, self._layer, self._state = control["sitting"], layer, ""
        if state != self._state:
            before, self._state = self._state, state
            if state in _PAUSES:
                happened.append({"what": NewsKind.PAUSE})
            if state == PrintState.FAULT and not control.get("fresh") and before:
                happened.append({"what": NewsKind.FAULT})
        if state == PrintState.PRINTING and layer > self._layer:
            self._layer = layer
            happened.append({"what": NewsKind.LAYER})
        return [self._about(control, sitting) | each for each in happened]

    def _ended(self, control: dict[str, Any]) -> list[News]:
        """Runs that have ended: by events, as the last state of a run is soon replaced by that of the next sitting."""
        events = control.get("events", [])
        seen, self._event = self._event, max((each[0] for each in events), default=self._event or 0)
        new = [] if seen is None else [text for number, _, kind, text in events if number > seen and kind == "run"]
        ended = [text.removeprefix("run ").partition(_ENDS) for text in new if _ENDS in text]
        return [{"what": NewsKind.END, "run": run, "status": status} for run, _, status in ended]

    @staticmethod
    def _about(control: dict[str, Any], sitting: dict[str, Any]) -> News:
        path = sitting.get("path") or {}
        return {
            "machine": sitting.get("machine", ""),
            "robot": sitting.get("robot", ""),
            "run": sitting.get("run"),
            "state": control["state"],
            "reason": control.get("reason", ""),
            "layer": control.get("layer"),
            "layers": path.get("layers"),
            "utc": control["utc"],
        }
