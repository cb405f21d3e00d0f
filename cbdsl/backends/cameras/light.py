"""The light in which every renderer shows the world: a wide lamp above the robot's shoulders."""

from __future__ import annotations

import numpy as np

_TOWARDS = np.array([-0.7, 0.15, 0.7])

#: Unit vector towards the lamp, world frame.
DIRECTION = tuple((_TOWARDS / np.linalg.norm(_TOWARDS)).tolist())

#: Share of the light that comes from all sides. What is white and looks at the robot or upwards is
#: then in the brightest of ten channels of intensity, as the white box of Figure 3.5 has to be.
AMBIENT = 0.85
