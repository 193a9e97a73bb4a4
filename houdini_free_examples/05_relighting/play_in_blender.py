"""blender --background --python play_in_blender.py -- FOLDER OUT.blend: relit.####.vdb as an animated volume."""
import glob
import os
import sys

import bpy

folder, output = (os.path.abspath(a) for a in sys.argv[sys.argv.index("--") + 1:][:2])
files = sorted(os.path.basename(f) for f in glob.glob(os.path.join(folder, "relit.????.vdb")))
assert files, f"no relit.####.vdb in {folder}"

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.object.volume_import(filepath=os.path.join(folder, files[0]), files=[{"name": f} for f in files],
                             directory=folder, align="WORLD")
volume = bpy.context.object
volume.data.is_sequence = True
volume.data.frame_start = 1
volume.data.frame_duration = len(files)

material = bpy.data.materials.new("light")
material.use_nodes = True
nodes, links = material.node_tree.nodes, material.node_tree.links
nodes.clear()
light = nodes.new("ShaderNodeAttribute")
light.attribute_name = "emission"
principled = nodes.new("ShaderNodeVolumePrincipled")
principled.inputs["Density"].default_value = 0
principled.inputs["Emission Strength"].default_value = 20
links.new(light.outputs["Color"], principled.inputs["Emission Color"])
links.new(principled.outputs["Volume"], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
volume.data.materials.append(material)

scene = bpy.context.scene
scene.frame_start, scene.frame_end = 1, len(files)
for frame in range(1, len(files) + 1):  # every frame has to load, and none be the one before
    scene.frame_set(frame)
    assert volume.data.grids.load(), volume.data.grids.error_message
    assert volume.data.grids.frame == frame, (volume.data.grids.frame, frame)
bpy.ops.wm.save_as_mainfile(filepath=output)
print(f"{output}: {len(files)} frames")
