"""Whether a shared group is as it was made: each thing that a user can change in it is noticed."""

import pytest
from measured_brdf.addon.core.blender import shared_groups


@pytest.fixture
def made(blender):
    """A group of each kind of node that shared groups have, by the module."""
    def fill(tree):
        tree.interface.new_socket("Value", in_out="INPUT", socket_type="NodeSocketFloat")
        source = tree.nodes.new("NodeGroupInput")
        for kind in ("ShaderNodeMath", "ShaderNodeVectorRotate", "ShaderNodeTexWhiteNoise", "ShaderNodeBsdfSheen"):
            tree.nodes.new(kind).name = kind
        tree.links.new(source.outputs[0], tree.nodes["ShaderNodeMath"].inputs[0])

    tree = shared_groups.shared_group("Tested", fill)
    yield tree
    blender.data.node_groups.remove(tree)


def clear_links(tree):
    tree.links.clear()


@pytest.mark.parametrize("change", [
    *(lambda tree, node=node, name=name, value=value: setattr(tree.nodes[node], name, value) for node, name, value in (
        ("ShaderNodeMath", "operation", "SUBTRACT"), ("ShaderNodeMath", "use_clamp", True),
        ("ShaderNodeMath", "mute", True), ("ShaderNodeMath", "name", "Other"),
        ("ShaderNodeVectorRotate", "rotation_type", "X_AXIS"), ("ShaderNodeVectorRotate", "invert", True),
        ("ShaderNodeTexWhiteNoise", "noise_dimensions", "1D"), ("ShaderNodeBsdfSheen", "distribution", "ASHIKHMIN"))),
    lambda tree: setattr(tree.nodes["ShaderNodeMath"].inputs[1], "default_value", 0.125), clear_links,
    lambda tree: setattr(tree.interface.items_tree[0], "default_value", 0.5),
    lambda tree: tree.interface.new_socket("More", in_out="INPUT", socket_type="NodeSocketFloat")])
def test_a_group_that_a_user_has_changed_is_not_the_one_that_was_made(made, change):
    assert shared_groups.is_unchanged(made)
    change(made)
    assert not shared_groups.is_unchanged(made)
