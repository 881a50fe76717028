"""Where a camera in the room sees the platform."""

from dataclasses import dataclass

from cablewright.foundation.arrays import Array
from cablewright.foundation.signals.reading import Reading, Source


@dataclass(frozen=True, eq=False)
class CameraPose(Reading, sources=[Source("camera", stream=16, topic="/camera_pose")]):
    """Pose of the platform by tags on it in one picture, in the world as the camera's file has it."""

    time: float  # s, of the middle of the exposure
    pose: Array  # (6,) m, rad: position of B, and rotation vector of the drum or body
    covariance: Array  # (36,) rows of that of translation, m, and rotation in space, rad, by noise of the pixels alone

    @property
    def spread(self) -> Array:
        """The covariance (6, 6)."""
        return self.covariance.reshape(6, 6)
