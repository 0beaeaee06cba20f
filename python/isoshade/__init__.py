# SPDX-License-Identifier: MIT
"""isoshade: volumes at several levels that keep their shading, and renderers that can be compared.

    import isoshade as iso
    v = iso.open("scan.nrrd")                    # or iso.Volume(array, spacing=(1, 1, 2.5))
    p = v.build(levels=4)
    image = p.render(tf="ct-bone", view="front", size=512)
    image.save("front.png")

Arrays of voxels are indexed [z, y, x]; sizes and spacings are (x, y, z), in mm. Long calls end by Ctrl-C. Pure Python
over libisoshade, by ctypes: $ISOSHADE_LIBRARY names its file if it is not installed.
"""
import warnings as _warnings

from . import _native
from ._images import Image, Metrics, compare, load_image
from ._native import Error, Status
from ._scenes import Scene, Tf
from ._validation import Report, Request, validate
from ._volumes import Level, Pyramid, Volume, open

__version__ = _native.lib.iso_version().decode()
__all__ = ["Error", "Image", "Level", "Metrics", "Pyramid", "Report", "Request", "Scene", "Status", "Tf", "Volume",
           "choices", "compare", "load_image", "open", "validate"]


def choices(kind: str):
    """Lists names: kind is "type", "code", "estimator", "scalar filter", "direction filter", "shading", "renderer",
    "export", "tf" or "view"."""
    if kind not in _native.CHOICES:
        raise ValueError(f"kind is {kind!r}, must be one of {', '.join(_native.CHOICES)}")
    return _native.choices(_native.CHOICES.index(kind))


for _name in __all__:
    globals()[_name].__module__ = __name__  # as messages and help() show it


@_native.WARNING
def _warn(_user, text):
    _warnings.warn(text.decode(errors="replace"), stacklevel=2)


_native.lib.iso_warnings_to(_warn, None)
