"""The panel of a measured material, and the menus: slices add to them. What every file needs is here: how materials are
rendered, what is wrong in a scene, and updates."""

from ..core.registration import Registration
from ..work import modal
from . import fixes, main, menu, nodes, rendering, update

_panel = Registration(modal, fixes, update, main, rendering, nodes, menu, additions=(
    *((name, menu.entry) for name in menu.MENUS), (nodes.ADD_MENU, nodes.entry),
    ("VIEW3D_MT_light_add", menu.add_studio)))
register, unregister = _panel.register, _panel.unregister
