"""volcaustic for Blender: glass, lights and fog of a scene become a volume of caustics, computed by the volcaustic program."""

bl_info = {
    "name": "volcaustic",
    "author": "volcaustic",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Properties > World, Properties > Object",
    "description": "Bakes volume caustics of glass objects into OpenVDB volumes",
    "category": "Render",
}

from . import job, operators, panels, settings  # noqa: E402  (bl_info is read from the file's top)

MODULES = (settings, operators, panels)


def register():
    for module in MODULES:
        module.register()


def unregister():
    job.stop_all()
    for module in reversed(MODULES):
        module.unregister()
