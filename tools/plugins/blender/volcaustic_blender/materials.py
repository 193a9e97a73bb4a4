"""Which materials bend light, and by how much."""

GLASS = {"ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction"}
TRANSMISSION = ("Transmission", "Transmission Weight")  # before and since Blender 4.0


def index_of(material):
    """The refractive index of a material that lets light through; None for all others."""
    if not material or not material.use_nodes or not material.node_tree:
        return None
    for node in material.node_tree.nodes:
        if node.bl_idname in GLASS:
            return node.inputs["IOR"].default_value
        if node.bl_idname == "ShaderNodeBsdfPrincipled":
            sockets = [node.inputs[name] for name in TRANSMISSION if name in node.inputs]
            if any(socket.is_linked or socket.default_value > 0.5 for socket in sockets):
                return node.inputs["IOR"].default_value
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
