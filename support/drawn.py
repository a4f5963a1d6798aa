"""Panels drawn without a window: what they would show, as plain values."""

# ruff: noqa: D102 (the methods are those of Blender's UILayout)

from types import SimpleNamespace

import bpy


class Layout:
    """Stands for a `UILayout`, and notes what is drawn: `texts`, `buttons` and `fields`, in the order of drawing.

    Of a layout inside of another that is not enabled, nothing is enabled.
    """

    _CONTAINERS = ("row", "column", "box", "split", "column_flow", "grid_flow")

    def __init__(self, parent=None):
        self._parent = parent
        self.drawn = parent.drawn if parent is not None else []
        self.enabled = True
        self.operator_context = "INVOKE_DEFAULT"

    def __getattr__(self, name):
        if name in self._CONTAINERS:
            return lambda **_options: Layout(self)
        raise AttributeError(name)

    def is_enabled(self):
        """Whether users can do anything here."""
        return self.enabled and (self._parent is None or self._parent.is_enabled())

    def label(self, text="", **_options):
        self._note("text", text)

    def progress(self, factor=0.0, text="", **_options):
        self._note("text", text)

    def template_icon(self, icon_value, scale=1.0):
        self._note("picture", icon_value)

    def context_pointer_set(self, _name, _data):
        """What operators of buttons look at, which is not noted."""

    def separator(self, **_options):
        """Space, which is not noted."""

    def prop(self, data, name, **_options):
        if not hasattr(data, name):
            raise AttributeError(f"{data} has no {name}")
        self._note("field", name)

    def prop_enum(self, data, name, value, **_options):
        self._note("choice", name, value)

    def popover(self, panel, text="", **_options):
        self._note("popover", panel, text)

    def template_node_view(self, _tree, node, socket):
        self._note("field", node.inputs[socket.name].name)

    def template_list(self, _kind, _name, data, items, active_data, active, **_options):
        """A list; its rows are not drawn."""
        for owner, name in ((data, items), (active_data, active)):
            self.prop(owner, name)

    def menu(self, name, **_options):
        self._note("menu", name)

    def panel(self, _name, default_closed=False):
        return Layout(self), None if default_closed else Layout(self)

    def operator(self, name, text="", **_options):
        """A button: the options that can be given to it."""
        module, function = name.split(".")
        about = getattr(getattr(bpy.ops, module), function).get_rna_type()      # raises where there is none
        options = SimpleNamespace()
        self._note("button", text or about.name, name, options)
        return options

    def _note(self, kind, *what):
        self.drawn.append((kind, self, *what))

    @property
    def texts(self):
        """All text that is not on buttons, lines put together."""
        return " ".join(entry[2] for entry in self.drawn if entry[0] == "text")

    @property
    def fields(self):
        """The properties that are shown."""
        return [entry[2] for entry in self.drawn if entry[0] == "field"]

    @property
    def kinds(self):
        """"text", "button", "field", "picture" or "menu" of everything."""
        return [entry[0] for entry in self.drawn]

    def button(self, text):
        """The button of this text: its operator, the options given to it, whether it is enabled, and its place."""
        for place, entry in enumerate(self.drawn):
            if entry[0] == "button" and entry[2] == text:
                return SimpleNamespace(operator=entry[3], options=vars(entry[4]), enabled=entry[1].is_enabled(),
                                       place=place)
        return None


def draw(panel, context=None, **shown):
    """Draw a panel, or a menu; `shown` are members of the context that it looks at, such as the material."""
    layout, context = Layout(), bpy.context if context is None else context
    names = ("scene", "screen", "object", "region", "preferences", "window_manager", "workspace", "space_data")
    given = {name: getattr(context, name, None) for name in names} | {"material": None, "window": None} | shown
    panel.draw(SimpleNamespace(layout=layout), SimpleNamespace(**given))
    return layout
