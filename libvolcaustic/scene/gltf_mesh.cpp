#include "scene/gltf_mesh.h"

#include "volcaustic/error.h"

#include <charconv>
#include <limits>

namespace volcaustic {

namespace {

constexpr std::uint64_t kTriangles = 4, kStrip = 5, kFan = 6;

std::uint64_t modeOf(const GltfValue& primitive) {
  const auto mode = primitive.find("mode");
  if (!mode) return kTriangles;
  if (mode->whole() > kFan) mode->fail("there is no such mode in glTF 2.0; give one from 0 to 6");
  return mode->whole();
}

GltfValue primitivesOf(const GltfFile& file, std::size_t mesh) { return file.item("meshes", mesh).at("primitives"); }

/// The corners of triangle `i`; of a strip every other one is turned, so that all face the same way.
std::array<std::uint64_t, 3> cornersOf(std::uint64_t mode, std::uint64_t i) {
  switch (mode) {
  case kStrip:
    return {i, i + 1 + i % 2, i + 2 - i % 2};
  case kFan:
    return {i + 1, i + 2, 0};
  default:
    return {3 * i, 3 * i + 1, 3 * i + 2};
  }
}

/// The number that `text` starts with, which is cut off.
std::optional<std::size_t> takeNumber(std::string_view& text) {
  std::size_t number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

bool takePrefix(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

/// The numbers of "1,2,5"; nothing when it is not that.
std::optional<std::vector<std::size_t>> takeList(std::string_view text) {
  std::vector<std::size_t> numbers;
  do {
    const auto number = takeNumber(text);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  } while (takePrefix(text, ","));
  return text.empty() ? std::optional(numbers) : std::nullopt;
}

} // namespace

bool GltfPrimitive::hasTriangles(const GltfValue& primitive) { return modeOf(primitive) >= kTriangles; }

GltfPrimitive::GltfPrimitive(GltfFile& file, const GltfValue& primitive)
    : mPlace(primitive), mMode(modeOf(primitive)), mPositions(file, primitive.at("attributes").at("POSITION"), "VEC3") {
  if (const auto indices = primitive.find("indices")) mIndices.emplace(file, *indices, "SCALAR");
  if (vertices() >= std::numeric_limits<std::uint32_t>::max())
    primitive.fail("more than 4294967294 vertices; split it");
  const std::uint64_t given = mIndices ? mIndices->count() : vertices();
  if (given < 3 || (mMode == kTriangles && given % 3 != 0))
    primitive.fail(std::to_string(given) + " corners do not make triangles; export it again");
}

std::uint64_t GltfPrimitive::corners() const {
  const std::uint64_t given = mIndices ? mIndices->count() : vertices();
  return mMode == kTriangles ? given : 3 * (given - 2);
}

void GltfPrimitive::appendTo(Mesh& mesh) const {
  const std::size_t first = mesh.positions.size();
  if (first + vertices() >= std::numeric_limits<std::uint32_t>::max())
    mPlace.fail("the mesh has too many vertices; split it");
  const std::vector<double> positions = mPositions.numbers();
  for (std::size_t i = 0; i < positions.size(); i += 3)
    mesh.positions.push_back({positions[i], positions[i + 1], positions[i + 2]});
  const std::vector<std::uint32_t> indices = mIndices ? mIndices->indices() : std::vector<std::uint32_t>();
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (indices[i] >= vertices())
      mPlace.fail("index number " + std::to_string(i) + " is " + std::to_string(indices[i]) + " of " +
                  std::to_string(vertices()) + " vertices; export it again");
  for (std::uint64_t i = 0; i < corners() / 3; ++i) {
    std::array<std::uint32_t, 3> triangle;
    const std::array<std::uint64_t, 3> at = cornersOf(mMode, i);
    for (std::size_t c = 0; c < 3; ++c)
      triangle[c] = static_cast<std::uint32_t>(first + (mIndices ? indices[at[c]] : at[c]));
    // Strips turn corners and join parts over triangles of no area.
    const bool isJoint = triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
    if (mMode == kTriangles || !isJoint) mesh.triangles.push_back(triangle);
  }
}

std::uint64_t checkGltfPrimitives(GltfFile& file, std::size_t mesh, const std::vector<std::size_t>& primitives) {
  const GltfValue all = primitivesOf(file, mesh);
  std::uint64_t bytes = 0;
  for (const std::size_t i : primitives) {
    const GltfPrimitive primitive(file, all[i]);
    bytes += primitive.vertices() * sizeof(Vec3d) + primitive.corners() * sizeof(std::uint32_t);
    file.context().requireMemory(bytes, file.name() + ":" + all.pointer());
  }
  return bytes;
}

Mesh readGltfPrimitives(GltfFile& file, std::size_t mesh, const std::vector<std::size_t>& primitives) {
  checkGltfPrimitives(file, mesh, primitives);
  const GltfValue all = primitivesOf(file, mesh);
  Mesh result;
  for (const std::size_t i : primitives) {
    file.context().throwIfCancelled();
    GltfPrimitive(file, all[i]).appendTo(result);
  }
  return result;
}

std::vector<std::size_t> gltfTriangles(const GltfFile& file, std::size_t mesh) {
  const GltfValue all = primitivesOf(file, mesh);
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (GltfPrimitive::hasTriangles(all[i])) numbers.push_back(i);
  return numbers;
}

std::string gltfFragment(std::size_t mesh, const std::vector<std::size_t>& primitives, bool all) {
  std::string fragment = "/meshes/" + std::to_string(mesh);
  for (std::size_t i = 0; !all && i < primitives.size(); ++i)
    fragment += (i == 0 ? "/primitives/" : ",") + std::to_string(primitives[i]);
  return fragment;
}

Mesh readGltfFragment(GltfFile& file, std::string_view fragment) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorKind::Input, file.name() + "#" + std::string(fragment) + ": " + what);
  };
  std::string_view rest = fragment;
  std::optional<std::size_t> mesh;
  if (takePrefix(rest, "/meshes/")) mesh = takeNumber(rest);
  std::optional<std::vector<std::size_t>> primitives;
  if (mesh && takePrefix(rest, "/primitives/"))
    primitives = takeList(rest);
  else if (mesh && rest.empty() && *mesh < file.count("meshes"))
    primitives = gltfTriangles(file, *mesh);
  else if (mesh && rest.empty())
    primitives.emplace();
  if (!mesh || !primitives) fail("names no mesh; write it as #/meshes/0 or #/meshes/0/primitives/1,2");
  if (*mesh >= file.count("meshes"))
    fail("there is no such mesh among the " + std::to_string(file.count("meshes")) + " of the file");
  const GltfValue all = primitivesOf(file, *mesh);
  for (const std::size_t i : *primitives)
    if (i >= all.size() || !GltfPrimitive::hasTriangles(all[i]))
      fail("primitive " + std::to_string(i) + " is no surface of the mesh; it has " + std::to_string(all.size()) +
           " primitives");
  Mesh result = readGltfPrimitives(file, *mesh, *primitives);
  if (result.empty()) fail("holds no triangle; a surface made of faces is needed");
  return result;
}

} // namespace volcaustic
