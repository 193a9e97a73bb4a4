/// \file options.h
/// The one description of every option: name, unit, range, meaning. JSON, the JSON Schema, command-line flags, help
/// text, stage keys and the tables in docs/ are all readers (visitors) of the describe functions below.
///
/// A visitor is called as visit(name, value, doc) for each field, in documented order; `value` is a reference to a
/// bool, int, double, std::string, std::filesystem::path, an array of numbers, an enumeration with enumNames, an
/// AutomaticBox, or a vector of names or of described structs. Nothing here allocates.
#pragma once

#include "volcaustic/medium.h"
#include "volcaustic/photons.h"
#include "volcaustic/scene.h"
#include "volcaustic/simulation.h"
#include "volcaustic/usd.h"
#include "volcaustic/vdb.h"
#include "volcaustic/view.h"

#include <array>
#include <filesystem>
#include <limits>
#include <span>

namespace volcaustic {

/// What a field means. Ranges are inclusive and hold for every component of an array.
struct FieldDoc {
  const char* text;
  const char* unit = "";
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::span<const int> choices = {}; ///< when not empty, the only values allowed
  bool required = false;             ///< has no sensible default: a file must give it
  bool alternative = false;          ///< of the fields of a struct that are, a file must give one
};

/// A box that may be left to be found: "auto" or {"min": [x, y, z], "max": [x, y, z]} in JSON.
struct AutomaticBox {
  bool& automatic;
  Box& box;
};

constexpr std::array<const char*, 3> enumNames(FillRule) { return {"auto", "exact", "winding"}; }
constexpr std::array<const char*, 6> enumNames(DeformerType) {
  return {"handle", "push", "pull", "inflate", "twist", "smooth"};
}
constexpr std::array<const char*, 2> enumNames(DeformMethod) { return {"asRigidAsPossible", "laplacian"}; }
constexpr std::array<const char*, 4> enumNames(Topology) { return {"free", "keep", "merge", "split"}; }
constexpr std::array<const char*, 2> enumNames(Scheme) { return {"driftKickDrift", "euler"}; }
constexpr std::array<const char*, 2> enumNames(Lookup) { return {"trilinear", "nearest"}; }
constexpr std::array<const char*, 4> enumNames(PixelFilter) { return {"box", "tent", "gaussian", "blackmanHarris"}; }
constexpr std::array<const char*, 5> enumNames(ExrCompression) { return {"none", "zips", "zip", "piz", "dwaa"}; }
constexpr std::array<const char*, 4> enumNames(OpticalProperty) {
  return {"index", "attenuation", "scattering", "asymmetry"};
}
constexpr std::array<const char*, 6> enumNames(HostPreset) {
  return {"none", "blender", "houdini", "arnold", "unreal", "renderman"};
}
constexpr std::array<const char*, 2> enumNames(UpAxis) { return {"y", "z"}; }
constexpr std::array<const char*, 2> enumNames(ToneCurve) { return {"plain", "aces"}; }
constexpr std::array<const char*, 5> enumNames(LightType) {
  return {"directional", "point", "spot", "environment", "area"};
}

inline constexpr std::array<int, 4> kSupersampleChoices{1, 2, 4, 8};
inline constexpr std::array<int, 6> kBlurChoices{1, 3, 5, 7, 9, 11};
inline constexpr std::array<int, 4> kBitsChoices{0, 8, 16, 32};
inline constexpr double kHuge = 1e9;

// One range for each quantity, so that every place that takes it agrees.
inline constexpr FieldDoc kIndexDoc{"refractive index", "1", 0.1, 10};
inline constexpr FieldDoc kAttenuationDoc{"extinction coefficient: absorption + out-scattering, RGB", "1/world", 0,
                                          kHuge};
inline constexpr FieldDoc kScatteringDoc{"scattering coefficient, RGB; at most the attenuation", "1/world", 0, kHuge};
inline constexpr FieldDoc kAsymmetryDoc{"Henyey-Greenstein mean cosine g", "1", -0.99, 0.99};

template <class Visitor>
void describe(Visitor&& visit, Material& m) {
  visit("index", m.index, kIndexDoc);
  visit("attenuation", m.attenuation, kAttenuationDoc);
  visit("scattering", m.scattering, kScatteringDoc);
  visit("asymmetry", m.asymmetry, kAsymmetryDoc);
}

template <class Visitor>
void describe(Visitor&& visit, Ambient& a) {
  visit("index", a.index, kIndexDoc);
  visit("attenuation", a.attenuation, kAttenuationDoc);
  visit("scattering", a.scattering, kScatteringDoc);
  visit("asymmetry", a.asymmetry, kAsymmetryDoc);
}

template <class Visitor>
void describe(Visitor&& visit, VoxeliseOptions& o) {
  visit("supersample", o.supersample,
        FieldDoc{"sub-voxels along a voxel's edge for the solid fraction", "", 1, 8, kSupersampleChoices});
  visit("blur", o.blur, FieldDoc{"width of the Gaussian on the index; 1 is none", "voxels", 1, 11, kBlurChoices});
  visit("fill", o.fill, FieldDoc{"how inside is told from outside: exact needs closed meshes, winding takes any"});
}

template <class Visitor>
void describe(Visitor&& visit, StepFieldOptions& o) {
  visit("indexTolerance", o.indexTolerance, FieldDoc{"range of index in a cube crossed in one step", "1", 0, 1});
  visit("indexTolerance2", o.indexTolerance2, FieldDoc{"range of index in a cube crossed in capped steps", "1", 0, 1});
  visit("cap", o.cap, FieldDoc{"longest step in a capped cube", "voxels", 0.1, 4096});
  visit("attenuationTolerance", o.attenuationTolerance,
        FieldDoc{"range of attenuation times voxel edge in a cube crossed in one step", "1", 0, kHuge});
}

template <class Visitor>
void describe(Visitor&& visit, Light& l) {
  visit("name", l.name, FieldDoc{"for messages, and of its layers and grids where lights are separate"});
  visit("type", l.type,
        FieldDoc{"directional light, point light, a spot: a point light that shines into a cone, the environment: "
                 "`background` from all directions, or an area light: a flat lamp that shines from its front"});
  visit("direction", l.direction,
        FieldDoc{"propagation of a directional light, axis of a spot, where an area light faces; any length", "1",
                 -kHuge, kHuge});
  visit("irradiance", l.irradiance, FieldDoc{"of a directional light, on a plane facing it, RGB", "W/m2", 0, 1e30});
  visit("position", l.position,
        FieldDoc{"of a point light or a spot, the middle of an area light", "world", -1e12, 1e12});
  visit("intensity", l.intensity,
        FieldDoc{"of a point light; on its axis of a spot, and of an area light (its power by pi), RGB", "W/sr", 0,
                 1e30});
  visit("outerAngle", l.outerAngle, FieldDoc{"half the opening angle of a spot's cone", "degrees", 0.01, 90});
  visit("innerAngle", l.innerAngle,
        FieldDoc{"angle from its axis within which a spot has its whole intensity; at most outerAngle", "degrees", 0,
                 90});
  visit("angle", l.angle,
        FieldDoc{"angular diameter of a directional light's disc (the sun's is 0.53); 0 gives sharp shadows", "degrees",
                 0, 90});
  visit("radius", l.radius,
        FieldDoc{"of the ball that a point light or a spot is; 0 gives sharp shadows", "world", 0, kHuge});
  visit("width", l.width, FieldDoc{"of an area light", "world", 0, kHuge});
  visit("height", l.height, FieldDoc{"of an area light", "world", 0, kHuge});
  visit("across", l.across,
        FieldDoc{"where the width of an area light goes; any length, what is along `direction` is left out", "1",
                 -kHuge, kHuge});
  visit("round", l.round, FieldDoc{"an area light is the ellipse in its rectangle"});
  visit("scale", l.scale, FieldDoc{"multiplies the light of the environment, RGB", "1", 0, 1e30});
  visit(
      "samples", l.samples,
      FieldDoc{"sharp lights that stand for one with an angle, a radius or an area, or for the environment; they share "
               "its photons; 0 takes 16, of the environment 64",
               "lights", 0, kMostLightSamples});
}

template <class Visitor>
void describe(Visitor&& visit, PhotonOptions& o) {
  visit("grid", o.grid, FieldDoc{"photon raster of each light, columns and rows", "photons", 1, 65536});
  visit("scheme", o.scheme, FieldDoc{"how a photon is carried: second order, or the paper's equations (6) and (7)"});
  visit("lookup", o.lookup, FieldDoc{"how n and its gradient are read between voxel centres"});
  visit("minStep", o.minStep, FieldDoc{"shortest step", "voxels", 0.01, 64});
  visit("maxStep", o.maxStep, FieldDoc{"longest step", "voxels", 0.01, 4096});
  visit("maxSteps", o.maxSteps, FieldDoc{"steps after which a photon is cut off and counted", "", 1, kHuge});
  visit("cutoff", o.cutoff, FieldDoc{"fraction of its first power below which a photon is cut off", "1", 0, 1});
  visit("roulette", o.roulette, FieldDoc{"Russian roulette below the cutoff instead of dropping"});
  visit("jitter", o.jitter, FieldDoc{"move each photon inside its raster cell, by a hash of seed and cell"});
  visit("smooth", o.smooth, FieldDoc{"3x3x3 Gaussian on the finished volume; keeps its total"});
  visit("separate", o.separate,
        FieldDoc{"trace and view each light by itself: a grid and layers of each, beside those of all"});
  visit("fresnel", o.fresnel,
        FieldDoc{"reflect photons, too, where the index changes within a few voxels, by the chance that Fresnel's "
                 "equations give"});
}

template <class Visitor>
void describe(Visitor&& visit, Camera& c) {
  visit("position", c.position, FieldDoc{"of the eye", "world", -1e12, 1e12});
  visit("target", c.target, FieldDoc{"point looked at", "world", -1e12, 1e12});
  visit("up", c.up, FieldDoc{"direction that is up in the picture", "1", -kHuge, kHuge});
  visit("fieldOfView", c.fieldOfView, FieldDoc{"vertical", "degrees", 0.01, 170});
  visit("resolution", c.resolution, FieldDoc{"width and height of the picture", "pixels", 1, 32768});
}

template <class Visitor>
void describe(Visitor&& visit, Background& b) {
  visit("bottom", b.bottom, FieldDoc{"radiance seen looking down, RGB", "W/(m2 sr)", 0, 1e30});
  visit("top", b.top,
        FieldDoc{"radiance seen looking up, RGB; equal to bottom it is one colour", "W/(m2 sr)", 0, 1e30});
  visit("up", b.up, FieldDoc{"axis of the gradient, pole of the map; any length", "1", -kHuge, kHuge});
  visit("file", b.file,
        FieldDoc{
            "map in latitude and longitude (.hdr, .exr, ...) that takes the gradient's place; relative to this file"});
  visit("turn", b.turn, FieldDoc{"of the map about `up`, counterclockwise seen from there", "degrees", -kHuge, kHuge});
  visit("scale", b.scale, FieldDoc{"multiplies the map, RGB", "1", 0, 1e30});
  visit("visible", b.visible, FieldDoc{"false: the camera sees black; environment lights shine as before"});
}

template <class Visitor>
void describe(Visitor&& visit, ViewOptions& o) {
  visit("step", o.step, FieldDoc{"step where the medium bends or scatters", "voxels", 0.05, 64});
  visit("samples", o.samples, FieldDoc{"rays along each side of a pixel", "", 1, 16});
  visit("filter", o.filter, FieldDoc{"what weighs a pixel's rays, where there are several: by name, as wide as usual"});
  visit("noise", o.noise,
        FieldDoc{"standard error, relative to their mean, at which tiles of the picture are done; 0 takes all samples",
                 "1", 0, 1});
  visit("maxSteps", o.maxSteps, FieldDoc{"steps after which a ray is cut off and counted", "", 1, kHuge});
  visit("fresnel", o.fresnel,
        FieldDoc{"split rays where the index changes within a few voxels: reflections of background and light"});
  visit("exposure", o.exposure, FieldDoc{"brightness of tone-mapped files", "stops", -40, 40});
}

template <class Visitor>
void describe(Visitor&& visit, Placement& p) {
  visit("translate", p.translate, FieldDoc{"applied last", "world", -1e12, 1e12});
  visit("rotate", p.rotate, FieldDoc{"about x, then y, then z", "degrees", -kHuge, kHuge});
  visit("scale", p.scale, FieldDoc{"applied before the rotation; negative mirrors", "1", -1e12, 1e12});
  visit("shear", p.shear,
        FieldDoc{"applied first: added to x for each y, to x for each z, to y for each z", "1", -1e12, 1e12});
}

template <class Visitor>
void describe(Visitor&& visit, SceneVolume& v) {
  AutomaticBox bounds{v.automatic, v.bounds};
  visit("bounds", bounds,
        FieldDoc{"box that light is computed in, or \"auto\": around the objects", "world", -1e12, 1e12});
  visit("margin", v.margin,
        FieldDoc{"added on every side of an automatic box, as a part of the objects' longest side", "1", 0, 100});
  visit("resolution", v.resolution, FieldDoc{"voxels along the longest side of the box", "voxels", 1, 32768});
  visit("voxelSize", v.voxelSize, FieldDoc{"edge of a voxel; above 0 it replaces the resolution", "world", 0, 1e12});
  visit("file", v.file, FieldDoc{"a .vdb with an `index` grid that takes the place of objects and box"});
  describe(visit, v.ambient);
}

template <class Visitor>
void describe(Visitor&& visit, SceneGroup& g) {
  visit("name", g.name,
        FieldDoc{.text =
                     "name of a group of the mesh: `usemtl`, else `g`, else `o` of an OBJ file, a solid of an STL file",
                 .required = true});
  visit("material", g.material, FieldDoc{.text = "name in `materials`", .required = true});
  visit("priority", g.priority, FieldDoc{"added to the object's; of equal ones the group wins", "", -1e6, 1e6});
}

template <class Visitor>
void describe(Visitor&& visit, GridMapping& m) {
  visit("scale", m.scale, FieldDoc{"what one unit of the grid is, RGB", "", -1e30, 1e30});
  visit("offset", m.offset, FieldDoc{"value where the grid is 0, RGB", "", -1e30, 1e30});
}

template <class Visitor>
void describe(Visitor&& visit, PropertyGrid& p) {
  visit("name", p.mapping.grid, FieldDoc{.text = "name of a grid in the file, as `density`", .required = true});
  visit("property", p.property, FieldDoc{.text = "what offset + scale * grid is", .required = true});
  describe(visit, p.mapping);
}

template <class Visitor>
void describe(Visitor&& visit, PolygoniseOptions& o) {
  visit(
      "resolution", o.resolution,
      FieldDoc{"cells along the longest side of a shape, for its triangles; 128 where this and all that follows are 0",
               "", 0, 32768});
  visit("cellSize", o.cellSize,
        FieldDoc{"edge of a cell of the triangles; above 0 it replaces the resolution", "world", 0, 1e12});
  visit("tolerance", o.tolerance,
        FieldDoc{"greatest distance between triangles and the shape; 0 takes what the cells give", "world", 0, 1e12});
  visit("triangles", o.triangles,
        FieldDoc{"at most as many, and nearly as many where nothing else is given; 0 is no limit", "", 0, 1e9});
}

template <class Visitor>
void describe(Visitor&& visit, Deformer& d) {
  visit("type", d.type,
        FieldDoc{.text = "a handle, which places a part of the surface and lets the rest follow, or a brush",
                 .required = true});
  visit("center", d.center, FieldDoc{"of the ball of vertices, in the space of the mesh", "mesh", -1e12, 1e12});
  visit("radius", d.radius,
        FieldDoc{"of the ball; handles hold all in it alike, brushes fade from its centre", "mesh", 0, 1e12});
  visit("direction", d.direction,
        FieldDoc{"that push and pull move along, or the mean normal where it is 0; axis of twist", "1", -kHuge, kHuge});
  visit("strength", d.strength,
        FieldDoc{"how far push, pull and inflate move; degrees of twist; part of smooth, 0 to 1", "", -1e12, 1e12});
  describe(visit, d.placement);
}

template <class Visitor>
void describe(Visitor&& visit, DeformOptions& o) {
  visit("deformMethod", o.method, FieldDoc{"how the surface follows its handles"});
  visit("deformIterations", o.iterations, FieldDoc{"of local rotations and positions", "", 1, 1000});
}

template <class Visitor>
void describe(Visitor&& visit, TopologyOptions& o) {
  visit("topology", o.topology,
        FieldDoc{"what becomes of parts of the mesh that meet: free to overlap, kept apart, merged; split cuts necks"});
  visit("gap", o.gap, FieldDoc{"between parts that are kept apart; 0 takes two remeshVoxels", "mesh", 0, 1e12});
  visit("blend", o.blend, FieldDoc{"width of the blend where parts merge; 0 joins them sharply", "mesh", 0, 1e12});
  visit("neck", o.neck, FieldDoc{"thickness below which split cuts; 0 takes four remeshVoxels", "mesh", 0, 1e12});
  visit(
      "remeshVoxel", o.voxelSize,
      FieldDoc{"of the level set where surfaces change; 0 takes half the mean edge of the triangles", "mesh", 0, 1e12});
}

template <class Visitor>
void describe(Visitor&& visit, SceneObject& o) {
  visit("name", o.name, FieldDoc{"for messages"});
  visit(
      "mesh", o.meshFile,
      FieldDoc{.text = "OBJ, PLY, STL or OFF file, or a mesh of a glTF file as x.glb#/meshes/0; relative to this file",
               .alternative = true});
  describe(visit, o.placement);
  visit("material", o.material, FieldDoc{"a name in `materials`"});
  visit("priority", o.priority, FieldDoc{"where objects overlap the higher one wins", "", -1e6, 1e6});
  visit("visible", o.visible, FieldDoc{"false leaves the object out"});
  visit("groups", o.groups, FieldDoc{"groups of the mesh that are made of another material: the wine of a glass"});
  visit("volume", o.volumeFile,
        FieldDoc{.text = ".vdb or .nvdb file in place of a mesh: smoke, hot air; relative to this file",
                 .alternative = true});
  visit("grids", o.grids, FieldDoc{"what grids of the volume are in the medium"});
  visit("shape", o.shape,
        FieldDoc{.text = "functional object in place of a mesh: a node, or a shape file, relative to this file",
                 .alternative = true});
  visit("triangulate", o.triangulate, FieldDoc{"make voxels of triangles of the shape, not of the shape itself"});
  describe(visit, o.polygonise);
  visit("deform", o.deform,
        FieldDoc{"steps of a deformation of the mesh, or of the shape's triangles, in their order"});
  describe(visit, o.deformation);
  describe(visit, o.topology);
}

template <class Visitor>
void describe(Visitor&& visit, SceneFrames& f) {
  visit("first", f.first, FieldDoc{"frame of the animation", "", -1e6, 1e6});
  visit("last", f.last, FieldDoc{"frame of the animation; at least the first", "", -1e6, 1e6});
  visit("rate", f.rate, FieldDoc{"frames per second", "1/s", 0.01, 1e4});
}

template <class Visitor>
void describe(Visitor&& visit, RigidBodyOptions& o) {
  visit("gravity", o.gravity, FieldDoc{"acceleration of everything that is not fixed", "world/s2", -kHuge, kHuge});
  visit("rate", o.framesPerSecond, FieldDoc{"frames per second", "1/s", 0.01, 1e4});
  visit("steps", o.steps, FieldDoc{"of the simulation for each frame", "", 1, 100});
}

template <class Visitor>
void describe(Visitor&& visit, MixingOptions& o) {
  visit("center", o.center, FieldDoc{"of the box", "world", -1e12, 1e12});
  visit("size", o.size, FieldDoc{"edges of the box", "world", 1e-9, 1e12});
  visit("resolution", o.resolution, FieldDoc{"cells along the box's longest side", "", 8, 1024});
  visit("rate", o.framesPerSecond, FieldDoc{"frames per second", "1/s", 0.01, 1e4});
  visit("inflow", o.inflow,
        FieldDoc{"speed of the jet of the second fluid, upwards from the bottom", "world/s", 0, kHuge});
  visit("inflowRadius", o.inflowRadius, FieldDoc{"of the jet", "world", 0, 1e12});
  visit("buoyancy", o.buoyancy, FieldDoc{"upward acceleration of the pure second fluid", "world/s2", -kHuge, kHuge});
  visit("viscosity", o.viscosity, FieldDoc{"kinematic", "world2/s", 0, kHuge});
  visit("diffusion", o.diffusion, FieldDoc{"of the concentration", "world2/s", 0, kHuge});
  visit("swirl", o.swirl, FieldDoc{"vorticity confinement: keeps small eddies; 0 is none", "1/s", 0, 100});
  visit("disturbance", o.disturbance, FieldDoc{"random part of the jet's velocity", "1", 0, 1});
}

template <class Visitor>
void describe(Visitor&& visit, SceneReceiver& r) {
  visit("name", r.name, FieldDoc{"of its light map; receiver0, receiver1, ... where empty"});
  visit(
      "mesh", r.meshFile,
      FieldDoc{"a mesh, as of objects, whose outside collects light; empty: a square of edge 1 around the origin that "
               "faces +z"});
  describe(visit, r.placement);
  visit("albedo", r.albedo, FieldDoc{"part of the light that it sends back, RGB", "1", 0, 1});
  visit("resolution", r.resolution,
        FieldDoc{"of its light map along the longer side; of the square map of a mesh", "texels", 8, 16384});
  visit("visible", r.visible, FieldDoc{"to the camera; one that is not still collects light and casts shadows"});
}

template <class Visitor>
void describe(Visitor&& visit, SurfaceOptions& o) {
  visit("grid", o.grid,
        FieldDoc{
            "grid to take the surface of, of vectors their length; coverage, else the first of numbers, when empty"});
  visit("isovalue", o.isovalue, FieldDoc{"value on the surface", "", -1e30, 1e30});
  visit("adaptivity", o.adaptivity, FieldDoc{"0 keeps every polygon, 1 merges flat regions the most", "1", 0, 1});
  visit("sharpen", o.sharpen, FieldDoc{"keep corners, edges and what is thinner than a voxel (coverage at 0.5)"});
}

template <class Visitor>
void describe(Visitor&& visit, MediumImport& o) {
  visit("voxelSize", o.voxelSize,
        FieldDoc{"edge of a voxel of a medium from a volume; 0 takes the smallest of the mapped grids", "world", 0,
                 1e12});
  visit("padding", o.padding, FieldDoc{"voxels around the active ones of the mapped grids", "voxels", 0, 4096});
  visit("blur", o.blur, FieldDoc{"width of the Gaussian on a body's index; 1 is none", "voxels", 1, 11, kBlurChoices});
}

template <class Visitor>
void describe(Visitor&& visit, VdbWriteOptions& o) {
  visit("preset", o.preset, FieldDoc{"the grids of light that a program uses, in 16 bits where those do"});
  visit("half", o.half, FieldDoc{"16-bit floats in .vdb files"});
  visit("parts", o.parts, FieldDoc{"also write the grids caustic and direct"});
  visit("exposure", o.exposure, FieldDoc{"multiply the grids of light by 2 to this power; recorded", "stops", -40, 40});
}

template <class Visitor>
void describe(Visitor&& visit, UsdWriteOptions& o) {
  visit("metersPerUnit", o.metersPerUnit, FieldDoc{"length of a unit of the world, in stages", "m", 1e-9, 1e9});
  visit("upAxis", o.upAxis, FieldDoc{"of the world, in stages"});
  visit("rate", o.rate, FieldDoc{"frames per second of stages", "1/s", 1e-3, 1e6});
}

template <class Visitor>
void describe(Visitor&& visit, ImageWriteOptions& o) {
  visit("layers", o.layers, FieldDoc{"channels to write, by name or as caustic.*; all when empty"});
  visit("half", o.half, FieldDoc{"16-bit floats in .exr files; depth and step counts stay 32-bit"});
  visit("compression", o.compression, FieldDoc{"of .exr files; dwaa loses something, all others nothing"});
  visit("tiles", o.tiles, FieldDoc{"edge of a tile of .exr files, from 8; 0 writes scan lines", "pixels", 0, 4096});
  visit("exposure", o.exposure, FieldDoc{"brightness of 8- and 16-bit files", "stops", -40, 40});
  visit("tone", o.tone, FieldDoc{"how light becomes a display value in 8- and 16-bit files"});
  visit("bits", o.bits,
        FieldDoc{"of a channel, in formats that have a choice; 32 are linear floats, 0 what is usual", "", 0, 32,
                 kBitsChoices});
  visit("alpha", o.alpha,
        FieldDoc{"keep alpha and leave out the background's light, in formats other than .exr that have alpha"});
}

template <class Visitor>
void describe(Visitor&& visit, FlipOptions& o) {
  visit("pixelsPerDegree", o.pixelsPerDegree,
        FieldDoc{"of visual angle at which FLIP looks: 67 is a 0.7 m wide display of 3840 pixels seen from 0.7 m", "1",
                 1, 1000});
  visit("highDynamicRange", o.highDynamicRange,
        FieldDoc{"linear light, compared at all its exposures; else display values"});
}

} // namespace volcaustic
