"""Which materials bend light, and by how much."""

GLASS = {"ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction"}
TRANSMISSION = ("Transmission", "Transmission Weight")  # before and since Blender 4.0


def nodes_behind(socket, groups=()):
    """The shaders that reach a socket, those inside node groups too."""
    for link in socket.links:
        node = link.from_node
        if node.bl_idname == "ShaderNodeGroup" and node.node_tree and node.node_tree not in groups:
            out = next((n for n in node.node_tree.nodes if n.bl_idname == "NodeGroupOutput" and n.is_active_output), None)
            inner = out and out.inputs.get(link.from_socket.name)
            if inner:
                yield from nodes_behind(inner, (*groups, node.node_tree))
            continue
        yield node
        for shader in node.inputs:
            if shader.type == "SHADER":
                yield from nodes_behind(shader, groups)


def number_of(socket):
    """Its own, or that of a Value node linked to it."""
    node = socket.links[0].from_node if socket.is_linked else None
    return node.outputs[0].default_value if node and node.bl_idname == "ShaderNodeValue" else socket.default_value


def index_of(material):
    """The refractive index of a material that lets light through; None for all others."""
    output = material and material.node_tree and material.use_nodes and material.node_tree.get_output_node("ALL")
    for node in nodes_behind(output.inputs["Surface"]) if output else ():
        if node.bl_idname in GLASS:
            return number_of(node.inputs["IOR"])
        if node.bl_idname == "ShaderNodeBsdfPrincipled":
            sockets = [node.inputs[name] for name in TRANSMISSION if name in node.inputs]
            if any(socket.is_linked or socket.default_value > 0.5 for socket in sockets):
                return number_of(node.inputs["IOR"])
    return None


def index_of_object(obj):
    """Of its first material that lets light through."""
    indices = (index_of(slot.material) for slot in obj.material_slots)
    return next((index for index in indices if index is not None), None)


def role_of(obj):
    """BODY, RECEIVER or IGNORE."""
    role = obj.volcaustic.role
    if role != "AUTO":
        return role
    return "BODY" if index_of_object(obj) is not None else "IGNORE"
