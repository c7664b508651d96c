"""Lights that go with the viewer: a key light over the left shoulder, fill and rim.

Whatever is seen is lit from the front, so that its shade tells its slope and no body sinks into
the ground; the key light makes the highlight that moves over a surface which is bent.
"""

from __future__ import annotations

from typing import Any

from vtkmodules.vtkRenderingCore import vtkLight

# name: direction to the light in the viewer's frame (right, up, towards him), strength, specular
LIGHTS = {
    "key": ((-0.55, 0.75, 1.0), 0.72, 1.0),
    "fill": ((0.9, -0.1, 0.8), 0.34, 0.0),
    "rim": ((0.2, -1.0, 0.25), 0.26, 0.25),
}


def add_lights(renderer: Any) -> None:
    """Replace the lights of a renderer."""
    renderer.RemoveAllLights()
    renderer.AutomaticLightCreationOff()
    for towards, strength, shine in LIGHTS.values():
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*towards)
        light.SetFocalPoint(0.0, 0.0, 0.0)
        light.SetIntensity(strength)
        light.SetSpecularColor(shine, shine, shine)
        renderer.AddLight(light)
