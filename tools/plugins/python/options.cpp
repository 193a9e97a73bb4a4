// Described structs as classes.
#include "described_class.h"

#include "arrays.h"

#include <cmath>
#include <sstream>
#include <volcaustic/error.h>

namespace volcaustic::python {

std::string annotationOf(const bool&) { return "bool"; }
std::string annotationOf(const int&) { return "int"; }
std::string annotationOf(const std::uint64_t&) { return "int"; }
std::string annotationOf(const double&) { return "float"; }
std::string annotationOf(const std::string&) { return "str"; }
std::string annotationOf(const std::filesystem::path&) { return "StrPath"; }
std::string annotationOf(const AutomaticBox&) { return "Box | Literal[\"auto\"]"; }
std::string annotationOf(const AutomaticNumber&) { return "float | None"; }
std::string annotationOf(const MeshSource&) { return "Mesh | StrPath | None"; }
std::string annotationOf(const Shape&) { return "Shape | None"; }
std::string annotationOf(const Placement&) { return "Placement"; }
std::string annotationOf(const std::shared_ptr<const Image>&) { return "Image | None"; }
std::string annotationOf(const std::map<std::string, std::string>&) { return "dict[str, str]"; }

std::string fieldText(const FieldDoc& doc, const std::string& annotation) {
  std::ostringstream text;
  text << doc.text;
  if (*doc.unit && std::string_view(doc.unit) != "1") text << " [" << doc.unit << "]";
  if (!doc.choices.empty()) {
    const char* before = "; ";
    for (const int choice : doc.choices) text << std::exchange(before, ", ") << choice;
  } else if (std::isfinite(doc.min) && std::isfinite(doc.max)) {
    text << "; " << doc.min << " to " << doc.max;
  } else if (annotation.starts_with("Literal[")) {
    text << "; " << annotation.substr(8, annotation.size() - 9);
  }
  return text.str();
}

void addOptions(py::module_& m) {
  RunContext context;
  noteFields(m, "Context", ContextFields{context});
  bindDescribed<Placement>(m, "Placement",
                           "Where and how large something is: shear, then scale, then rotation about x, y and z, then "
                           "translation.");
  bindDescribed<Material>(m, "Material", "What light meets inside a body. Spectra are linear Rec. 709 RGB.");
  bindDescribed<Ambient>(m, "Ambient", "What light meets outside of all bodies.");
  bindDescribed<VoxeliseOptions>(m, "VoxeliseOptions", "From surfaces to voxels.");
  bindDescribed<StepFieldOptions>(m, "StepFieldOptions", "How far light may go in one step.");
  bindDescribed<Light>(m, "Light", "A source of photons.");
  bindDescribed<PhotonOptions>(m, "PhotonOptions", "The photon pass.");
  bindDescribed<Camera>(m, "Camera", "Where a picture is taken from.");
  bindDescribed<Background>(m, "Background", "What is around the box, infinitely far away.");
  bindDescribed<ViewOptions>(m, "ViewOptions", "The camera pass.");
  bindDescribed<GridMapping>(m, "GridMapping", "What a grid made by others means: offset + scale * grid.");
  bindDescribed<PropertyGrid>(m, "PropertyGrid", "What one grid of a volume is in a medium: offset + scale * grid.");
  bindDescribed<Deformer>(m, "Deformer", "One step of a deformation: a handle or a brush.");
  bindDescribed<SceneGroup>(m, "SceneGroup", "What the triangles of one group of an object's mesh enclose.");
  bindDescribed<SceneVolume>(m, "SceneVolume",
                             "The box that light is computed in, and what fills it where no body is.");
  bindDescribed<ObjectHandle>(m, "SceneObject",
                              "A body (mesh or shape), or a volume made by others in the ambient medium.");
  bindDescribed<SceneReceiver>(m, "SceneReceiver",
                               "An opaque diffuse surface that light falls on; without a mesh, a square of edge 1.");
  bindDescribed<SceneFrames>(m, "SceneFrames", "The frames of an animation.");
  noteFields<PolygoniseOptions>(m, "PolygoniseOptions");
  noteFields<DeformOptions>(m, "DeformOptions");
  noteFields<TopologyOptions>(m, "TopologyOptions");
  noteFields<SurfaceOptions>(m, "SurfaceOptions");
  noteFields<MeshWriteOptions>(m, "MeshWriteOptions");
  noteFields<VdbWriteOptions>(m, "VdbWriteOptions");
  noteFields<UsdWriteOptions>(m, "UsdWriteOptions");
  noteFields<ImageWriteOptions>(m, "ImageWriteOptions");
  noteFields<FlipOptions>(m, "FlipOptions");
  noteFields<MediumImport>(m, "MediumImport");
}

} // namespace volcaustic::python
