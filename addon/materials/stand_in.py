"""What a measured material looks like where OSL does not run: in EEVEE, and in the solid viewport."""

_NODE = "Measured BRDF Fallback"


def update(material, outcome):
    """Set the viewport's colour, and a Principled BSDF behind an output for EEVEE, as near to the data as they can be.

    A user's own output for EEVEE is left alone.
    """
    close = outcome.principled
    material.diffuse_color = (*outcome.albedo, 1)
    material.roughness, material.metallic = close.roughness, close.metallic
    tree = material.node_tree
    node = tree.nodes.get(_NODE)
    if node is None:
        node = _add(tree)
    if node is not None and node.bl_idname == "ShaderNodeBsdfPrincipled":
        for name, value in (("Base Color", (*close.base_color, 1)), ("Roughness", close.roughness),
                            ("Metallic", close.metallic), ("Specular IOR Level", close.specular_level)):
            node.inputs[name].default_value = value


def _add(tree):
    """The fallback node, connected to an output of its own; None where the user has made one.

    The material has an output for Cycles.
    """
    cycles = tree.get_output_node("CYCLES")
    if any(node.type == "OUTPUT_MATERIAL" and node.target == "EEVEE" for node in tree.nodes):
        return None
    if cycles.target == "ALL":
        cycles.target = "CYCLES"
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    node.name = node.label = _NODE
    output.target = "EEVEE"
    node.location = cycles.location.x - 260, cycles.location.y - 250
    output.location = cycles.location.x, cycles.location.y - 250
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    return node
