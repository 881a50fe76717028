"""Digital inputs that concern the machine's safety."""

from dataclasses import dataclass

from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class Inputs(Reading, sources=[Source("inputs", stream=12, topic="/inputs")]):
    """Safety inputs of the machine. The safety circuit itself stops the machine; these only show its state."""

    time: float  # s
    chain_closed: bool  # the emergency-stop chain
    torque_off: bool  # safe torque off is active
    enabling: bool  # an enabling switch is pressed; true where there is none
    brakes_closed: tuple[bool, ...]  # (m,) as the brakes' own contacts say; none without such contacts
