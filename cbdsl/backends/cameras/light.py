"""The light in which every renderer shows the world: a wide lamp above the robot's shoulders."""

from __future__ import annotations

import numpy as np

_TOWARDS = np.array([-0.7, 0.15, 0.7])

#: Unit vector towards the lamp, world frame.
DIRECTION = tuple((_TOWARDS / np.linalg.norm(_TOWARDS)).tolist())

#: Share of ambient light. White surfaces that face the robot or upwards are then in the brightest
#: of ten channels of intensity, as required for the white box of Figure 3.5.
AMBIENT = 0.85
