"""What is stored in the .blend and in the preferences."""

import bpy
from bpy.props import (BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty,
                       StringProperty)


class VolcausticPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program", subtype="FILE_PATH",
        description="The volcaustic program; empty: the environment's VOLCAUSTIC, or the one on the PATH")

    def draw(self, context):
        self.layout.prop(self, "program")


class VolcausticObject(bpy.types.PropertyGroup):
    role: EnumProperty(
        name="Role", default="AUTO", options=set(),
        items=[("AUTO", "Auto", "A body where a material is glass, refraction or transmits; else nothing"),
               ("BODY", "Body", "Bends light, whatever its material"),
               ("RECEIVER", "Receiver", "Opaque: light ends here, and it casts shadows into the volume"),
               ("IGNORE", "Ignore", "Light passes as if it were not there")])
    own_index: BoolProperty(name="Own Index", options=set(),
                            description="Take the refractive index from here, not from the material")
    index: FloatProperty(name="Refractive Index", default=1.5, min=0.1, max=10, options=set())
    absorption: FloatVectorProperty(name="Absorption", subtype="COLOR", min=0, soft_max=1, max=1e6, options=set(),
                                    description="Absorption coefficient inside, 1 per unit of length")
    scattering: FloatVectorProperty(name="Scattering", subtype="COLOR", min=0, soft_max=1, max=1e6, options=set(),
                                    description="Scattering coefficient inside, 1 per unit of length")
    priority: IntProperty(name="Priority", options=set(), description="Where bodies overlap, the higher one wins")


class VolcausticScene(bpy.types.PropertyGroup):
    domain: PointerProperty(
        name="Domain", type=bpy.types.Object,
        description="Its box is where light is computed; empty: a box around all bodies")
    resolution: IntProperty(name="Resolution", default=128, min=8, max=4096, options=set(),
                            description="Voxels along the longest side of the domain")
    photons: IntProperty(name="Photons", default=1024, min=8, max=16384, options=set(),
                         description="Rays of each light along each side of the domain as the light sees it")
    fog_scattering: FloatProperty(
        name="Fog", default=0.1, min=0, soft_max=1, max=1e6, options=set(),
        description="Scattering coefficient around the bodies, 1 per unit of length: caustics are seen in fog")
    fog_absorption: FloatProperty(name="Absorption", default=0, min=0, soft_max=1, max=1e6, options=set(),
                                  description="Absorption coefficient of the fog, 1 per unit of length")
    light_samples: IntProperty(
        name="Samples of Lamps", default=16, min=1, max=1024, options=set(),
        description="Points that stand for a lamp with a size; where glass makes an image of one, few of them show")
    world_light: BoolProperty(
        name="World Light", options=set(),
        description="Trace the light of the world's color or map, too; it needs more photons than a lamp")
    baked: StringProperty(description="Pattern of the latest bake's volumes", options=set())
    result: PointerProperty(type=bpy.types.Object, description="The volume object of the latest bake")


CLASSES = (VolcausticPreferences, VolcausticObject, VolcausticScene)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.volcaustic = PointerProperty(type=VolcausticObject)
    bpy.types.Scene.volcaustic = PointerProperty(type=VolcausticScene)


def unregister():
    del bpy.types.Scene.volcaustic
    del bpy.types.Object.volcaustic
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
