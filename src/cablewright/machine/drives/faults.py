"""Error codes of drives (CiA 301 and CiA 402, object 0x603F) as texts, and what to do about each."""

from __future__ import annotations

from typing import Final, NamedTuple


class FaultText(NamedTuple):
    """Meaning of an error code, and the next step for a person."""

    meaning: str
    remedy: str


TEXTS: Final = {
    0x2310: FaultText("continuous over current", "a line is blocked or too heavy: free it, check its load"),
    0x2320: FaultText("short circuit", "switch off; check the motor's cable and winding"),
    0x2340: FaultText("short circuit in the motor", "switch off; check the motor's cable and winding"),
    0x3110: FaultText("mains over voltage", "check the supply"),
    0x3120: FaultText("mains under voltage", "check the supply and its fuse"),
    0x3210: FaultText("over voltage of the DC link", "check the brake resistor: lowering a load feeds power back"),
    0x3220: FaultText("under voltage of the DC link", "check the supply, and whether safe torque off has cut it"),
    0x4210: FaultText("the drive is too hot", "let it cool; check its fan and the load"),
    0x4310: FaultText("the motor is too hot", "let it cool; check the load and the brake"),
    0x5441: FaultText("safe torque off is active", "close the emergency-stop chain, find out who opened it"),
    0x7121: FaultText("the motor is blocked", "check the brake, and whether the line is caught"),
    0x7180: FaultText("the motor turns too fast", "check 0x6080 and the load: a line may be broken"),
    0x7305: FaultText("the encoder is faulty", "check its cable; home the machine again"),
    0x8110: FaultText("CAN: frames were lost", "check termination, shields and the bus load"),
    0x8120: FaultText("CAN: error passive", "check termination and cable"),
    0x8130: FaultText("the heartbeat of the computer is missing", "find out why the program stopped or was held up"),
    0x8140: FaultText("CAN: recovered from bus off", "check termination and cable"),
    0x8210: FaultText("a PDO was too short", "another program or master may be on the bus"),
    0x8250: FaultText("no command came in time", "find out why the program was held up"),
    0x8311: FaultText("too much torque", "a line is caught or overloaded: relieve it by hand"),
    0x8400: FaultText("the speed is wrong", "check the load, the encoder and the controller's gains"),
    0x8611: FaultText("following error", "the load is too heavy for the torque limit, or the line is caught"),
    0xFF01: FaultText("the brake does not open or close", "check the brake and its supply; secure the load first"),
}

_FAMILIES: Final = {
    0x1: FaultText("generic error", "look the code up in the drive's manual"),
    0x2: FaultText("a current is wrong", "check the motor's cable and the load"),
    0x3: FaultText("a voltage is wrong", "check the supply"),
    0x4: FaultText("a temperature is wrong", "let it cool; check the load"),
    0x5: FaultText("the drive's hardware is faulty", "look the code up in the drive's manual"),
    0x6: FaultText("the drive's software reports an error", "look the code up in the drive's manual"),
    0x7: FaultText("a module of the drive is faulty", "look the code up in the drive's manual"),
    0x8: FaultText("the drive's supervision has tripped", "look the code up in the drive's manual"),
    0x9: FaultText("an external error", "look the code up in the drive's manual"),
    0xF: FaultText("an error of its maker's own", "look the code up in the drive's manual"),
}

_OTHER: Final = FaultText("a fault without a code", "look at the drive's own display")


def fault_text(code: int) -> FaultText:
    """Return the meaning of an error *code*: its own, or that of the family of its first digit."""
    return TEXTS.get(code) or _FAMILIES.get(code >> 12, _OTHER)


def fault_line(code: int) -> str:
    """Return an error code as one line of text: ``0x8611 following error: the load is ...``."""
    text = fault_text(code)
    return f"0x{code:04X} {text.meaning}: {text.remedy}"
