"""Real-time ray tracing with the same bits on every machine.

>>> import rtrt
>>> scene = rtrt.Scene.load("demo:matchbox")
>>> rtrt.render(scene, size=(640, 360))["rgba"].shape
(360, 640, 4)
"""

from ._native import AOVS, Backend, Before, Camera, Light, Scene, __version__, meter, render

__all__ = ["AOVS", "Backend", "Before", "Camera", "Light", "Scene", "__version__", "meter", "render"]
