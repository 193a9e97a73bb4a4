"""Where the settings are shown."""

import bpy

from . import export, materials, operators


class VOLCAUSTIC_PT_world(bpy.types.Panel):
    bl_label = "Caustics"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "world"

    def draw(self, context):
        layout, settings = self.layout, context.scene.volcaustic
        layout.use_property_split = True
        for name in ("domain", "resolution", "photons", "light_samples", "fog_scattering", "fog_absorption", "world_light"):
            layout.prop(settings, name)
        running = operators.current
        if running:
            layout.label(text=running.text, icon="TIME")
            layout.operator("volcaustic.cancel", icon="X")
            return
        row = layout.row()
        row.operator("volcaustic.bake", text="Bake Frame").span = "FRAME"
        row.operator("volcaustic.bake", text="Bake Animation").span = "ANIMATION"
        if not bpy.data.is_saved:
            layout.label(text="Save the file first to keep what is baked", icon="INFO")
        elif settings.baked and not settings.baked.startswith("//"):
            layout.label(text="Bake again to keep it: it is in a temporary folder", icon="INFO")
        rendered = export.rendered_objects(context.view_layer)
        bodies = [o.name for o in context.scene.objects
                  if o.name in rendered and o.type in export.MESH_TYPES and materials.role_of(o) == "BODY"]
        layout.label(text="Bends light: " + (", ".join(bodies) or "nothing yet"))


class VOLCAUSTIC_PT_object(bpy.types.Panel):
    bl_label = "Caustics"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return context.object and context.object.type in export.MESH_TYPES

    def draw(self, context):
        layout, settings = self.layout, context.object.volcaustic
        layout.use_property_split = True
        layout.prop(settings, "role")
        if materials.role_of(context.object) != "BODY":
            return
        found = materials.index_of_object(context.object)
        layout.prop(settings, "own_index")
        if settings.own_index or found is None:
            layout.prop(settings, "index")
        else:
            layout.label(text=f"Refractive index of the material: {found:.3f}")
        for name in ("absorption", "scattering", "priority"):
            layout.prop(settings, name)


CLASSES = (VOLCAUSTIC_PT_world, VOLCAUSTIC_PT_object)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
