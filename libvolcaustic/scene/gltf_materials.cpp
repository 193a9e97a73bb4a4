#include "scene/gltf_materials.h"

#include "volcaustic/options.h"

#include <cmath>
#include <set>

namespace volcaustic {

namespace {

/// Less than this of the light through the attenuation distance counts as this: black has no finite coefficient.
constexpr double kDarkest = 1e-6;

double indexOf(const GltfValue& material, GltfNotes& notes) {
  constexpr double kDefault = 1.5;
  const auto extension = material.extension("KHR_materials_ior");
  const auto ior = extension ? extension->find("ior") : std::nullopt;
  if (!ior) return kDefault;
  if (ior->number() == 0) {
    notes.add(*ior, "an ior of 0 says that there is none to refract with; 1.5 is taken");
    return kDefault;
  }
  return ior->number(kIndexDoc.min, kIndexDoc.max);
}

/// Beer-Lambert: after `attenuationDistance` there is `attenuationColor` of white light left.
Rgb attenuationOf(const GltfValue& material) {
  const auto volume = material.extension("KHR_materials_volume");
  const auto distance = volume ? volume->find("attenuationDistance") : std::nullopt;
  const auto colour = volume ? volume->find("attenuationColor") : std::nullopt;
  if (!distance || !colour) return {0, 0, 0};
  if (colour->size() != 3) colour->fail("must be an array of 3 numbers");
  if (distance->number(0) == 0) distance->fail("must be above 0; leave it out for clear glass");
  Rgb attenuation;
  for (std::size_t c = 0; c < 3; ++c) {
    const double left = std::max((*colour)[c].number(0, 1), kDarkest);
    attenuation[c] = left < 1 ? -std::log(left) / distance->number() : 0;
    if (attenuation[c] > kAttenuationDoc.max) distance->fail("is so short that nothing passes; make it longer");
  }
  return attenuation;
}

bool transmits(const GltfValue& material) {
  const auto transmission = material.extension("KHR_materials_transmission");
  const auto factor = transmission ? transmission->find("transmissionFactor") : std::nullopt;
  return factor && factor->number(0, 1) > 0;
}

/// What of a transmitting material a scene cannot hold.
void noteSurface(const GltfValue& material, GltfNotes& notes) {
  if (const auto dispersion = material.extension("KHR_materials_dispersion"))
    if (const auto value = dispersion->find("dispersion"); value && value->number(0) > 0)
      notes.add(*value, "a dispersion of " + excerpt(value->number()) +
                            " is read, and all colours get the same index: rainbows are not rendered");
  const auto pbr = material.find("pbrMetallicRoughness");
  if (!pbr) return;
  if (const auto roughness = pbr->find("roughnessFactor"); roughness && roughness->number() > 0)
    notes.add(*roughness, "rough glass is rendered as if it were smooth");
  if (const auto base = pbr->find("baseColorFactor"))
    for (std::size_t c = 0; c < 3 && c < base->size(); ++c)
      if ((*base)[c].number() < 1) {
        notes.add(*base, "the base colour does not tint the glass; colour it by KHR_materials_volume");
        break;
      }
}

/// The base colour of an opaque material. What is not matte is rendered as if it were.
Rgb albedoOf(const GltfValue& material, GltfNotes& notes) {
  Rgb albedo{1, 1, 1};
  const auto pbr = material.find("pbrMetallicRoughness");
  if (!pbr) return albedo;
  if (const auto base = pbr->find("baseColorFactor")) {
    if (base->size() != 4) base->fail("must be an array of 4 numbers");
    for (std::size_t c = 0; c < 3; ++c) albedo[c] = (*base)[c].number(0, 1);
  }
  if (pbr->find("baseColorTexture"))
    notes.add(*pbr, "the texture of an opaque surface is not read; it has its base colour all over");
  if (const auto metallic = pbr->find("metallicFactor"); metallic && metallic->number() > 0)
    notes.add(*metallic, "metal is rendered as if it were matte");
  return albedo;
}

std::string uniqueName(const GltfValue& material, std::size_t number, std::set<std::string>& taken) {
  const auto given = material.find("name");
  std::string name = given ? given->text() : "";
  if (name.empty()) name = "material " + std::to_string(number);
  while (!taken.insert(name).second) name += " " + std::to_string(number);
  return name;
}

} // namespace

std::vector<GltfMaterial> gltfMaterials(const GltfFile& file, GltfNotes& notes) {
  std::vector<GltfMaterial> materials;
  std::set<std::string> names{"opaque"}; // what primitives without a material get
  for (std::size_t i = 0; i < file.count("materials"); ++i) {
    const GltfValue value = file.item("materials", i);
    GltfMaterial material;
    material.material.name = uniqueName(value, i, names);
    material.material.index = indexOf(value, notes);
    material.material.attenuation = attenuationOf(value);
    material.transmits = transmits(value);
    if (material.transmits)
      noteSurface(value, notes);
    else
      material.albedo = albedoOf(value, notes);
    materials.push_back(std::move(material));
  }
  materials.emplace_back().material.name = "opaque";
  return materials;
}

} // namespace volcaustic
