"""A person who types orders, for prints on drives."""

from __future__ import annotations

from cablewright.foundation.signals import PrintState
from cablewright.live.drives.printing import PersonOperator
from cablewright.live.prints.loop import Printer


class Typist(PersonOperator):
    """Types one word in each state, some steps after it was entered."""

    def __init__(self, words: dict[PrintState, list[str]], last: int = 100_000) -> None:
        self.words, self.said, self.waited, self.last = words, list[str](), 0, last
        super().__init__(lambda: self.line, lambda: self.last <= 0, self.said.append)
        self.line: list[str] = []

    def orders(self, printer: Printer, now: float):  # type: ignore[no-untyped-def]
        self.waited, self.last = self.waited + 1, self.last - 1
        todo, self.line = self.words.get(printer.supervisor.state), []
        if todo and self.waited >= 20:
            self.line, self.waited = [todo.pop(0)], 0
        return super().orders(printer, now)


WORDS = {
    PrintState.FAULT: ["reset"],
    PrintState.OFF: ["start", "enable"],
    PrintState.IDLE: ["dance", "home", "start"],
}
