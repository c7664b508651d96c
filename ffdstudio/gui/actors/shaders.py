"""Small pieces of fragment shader that VTK's own are extended by.

They are plain text put where VTK says that its implementation goes (`//VTK::...::Impl`); what
they read, `normalVCVSOutput` and `vertexVC`, VTK declares for polygons with normals.
"""

from __future__ import annotations

from typing import Any

LIGHT = "//VTK::Light::Impl"
# What the surface mirrors of a room with parallel tubes above and ahead: stripes that jump where
# it has an edge, break where its slope is continuous only, and run smooth where its curvature is.
# As soft bands they are part of the plain look: a slope that changes by two degrees moves them.
MIRROR = """//VTK::Light::Impl
  vec3 ffdNormal = normalize(normalVCVSOutput);
  vec3 ffdEye = cameraParallel == 1 ? vec3(0.0, 0.0, -1.0) : normalize(vertexVC.xyz);
  vec3 ffdMirror = reflect(ffdEye, ffdNormal);
  float ffdPhase = FREQUENCY * atan(ffdMirror.y + 0.35 * ffdMirror.x, ffdMirror.z + 1.3);
  float ffdStep = fwidth(ffdPhase);
  float ffdSoft = 1.0 - smoothstep(0.7, 2.4, ffdStep);
"""
SOFT = (
    MIRROR.replace("FREQUENCY", "200.0")
    + """
  gl_FragData[0].rgb *= 1.0 + STRENGTH * ffdSoft * sin(ffdPhase);
""".replace("STRENGTH", "0.15")
)
REFLECTION = (
    MIRROR.replace("FREQUENCY", "260.0")
    + """
  float ffdStripe = smoothstep(-ffdStep, ffdStep, sin(ffdPhase));
  gl_FragData[0].rgb *= mix(1.0, mix(0.25, 1.05, ffdStripe), ffdSoft);
"""
)
# Every second pixel in a diagonal pattern: the surfaces behind are seen through it, whatever the
# order they are drawn in, and surfaces that coincide do not add up to an opaque one.
SCREEN_DOOR = """//VTK::Light::Impl
  if (mod(floor(gl_FragCoord.x) + 2.0 * floor(gl_FragCoord.y), 5.0) > 0.5) discard;
"""


def extend(actor: Any, code: str) -> None:
    """Let an actor's fragments be made by this code, or by VTK's alone if it is empty."""
    property_ = actor.GetShaderProperty()
    property_.ClearAllFragmentShaderReplacements()
    if code:
        property_.AddFragmentShaderReplacement(LIGHT, False, code, False)
