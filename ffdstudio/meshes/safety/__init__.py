"""Safety of a deformation: the exact safe amplitude and the live guard of a drag."""

from ffdstudio.meshes.safety.amplitude import safe_amplitude
from ffdstudio.meshes.safety.guard import Guard
from ffdstudio.meshes.safety.limits import INVERSION, PRESETS, Limits, Stop

__all__ = ["INVERSION", "PRESETS", "Guard", "Limits", "Stop", "safe_amplitude"]
