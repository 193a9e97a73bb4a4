"""The baked volume as an object that Cycles renders as it is."""

import bpy

NAME = "volcaustic"


def material():
    """Emits the light that the fog scatters. Its density only absorbs: what it scatters is in the emission already."""
    made = bpy.data.materials.get(NAME)
    if made:
        return made
    made = bpy.data.materials.new(NAME)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    shader = nodes.new("ShaderNodeVolumePrincipled")
    for socket, grid, output in (("Emission Color", "emission", "Color"), ("Density", "density", "Fac")):
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = grid
        links.new(attribute.outputs[output], shader.inputs[socket])
    shader.inputs["Color"].default_value = (0, 0, 0, 1)
    shader.inputs["Density Attribute"].default_value = ""
    shader.inputs["Emission Strength"].default_value = 1
    links.new(shader.outputs["Volume"], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    return made


def show(scene, pattern, frames):
    """Makes the volume object, or gives the one of the bake before its new files. \\returns the object."""
    settings = scene.volcaustic
    obj = settings.result
    if not obj or obj.type != "VOLUME" or obj.name not in scene.objects:
        obj = bpy.data.objects.new(NAME, bpy.data.volumes.new(NAME))
        scene.collection.objects.link(obj)
        obj.data.materials.append(material())
        settings.result = obj
    data = obj.data
    data.grids.unload()
    data.is_sequence = len(frames) > 1
    if bpy.data.is_saved:
        pattern = bpy.path.relpath(pattern)  # so that the folder can be moved
    data.filepath = pattern.replace("####", f"{frames[0]:04d}")
    if data.is_sequence:
        data.frame_start, data.frame_duration = frames[0], len(frames)
        data.frame_offset = frames[0] - 1
    data.render.clipping = 0  # Blender would drop what is below 0.001
    settings.baked = pattern
    return obj
