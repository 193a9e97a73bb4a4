// Meshes whose groups are different bodies.
#include "core/nearest_word.h"
#include "mesh/validate.h"
#include "volcaustic/error.h"
#include "volcaustic/medium.h"

#include <map>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

namespace volcaustic {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// Takes triangles out of a mesh, with the vertices and the groups that they use.
class Extractor {
public:
  explicit Extractor(const Mesh& mesh)
      : mMesh(mesh), mVertex(mesh.positions.size(), kNone), mGroup(mesh.groupNames.size(), kNone) {}

  Mesh extract(const std::vector<std::uint32_t>& triangles) {
    Mesh part;
    for (const std::uint32_t i : triangles) {
      auto corners = mMesh.triangles[i];
      for (std::uint32_t& v : corners) v = numbered(mVertex, v, mMesh.positions, part.positions);
      part.triangles.push_back(corners);
      if (!mMesh.triangleGroup.empty())
        part.triangleGroup.push_back(numbered(mGroup, mMesh.triangleGroup[i], mMesh.groupNames, part.groupNames));
    }
    for (const std::uint32_t i : triangles) { // time in proportion to the part, whatever the size of the mesh
      for (const std::uint32_t v : mMesh.triangles[i]) mVertex[v] = kNone;
      if (!mMesh.triangleGroup.empty()) mGroup[mMesh.triangleGroup[i]] = kNone;
    }
    return part;
  }

private:
  /// The number in the part of element `i` of the mesh, which comes along at its first use.
  template <class T>
  static std::uint32_t numbered(std::vector<std::uint32_t>& numbers, std::uint32_t i, const std::vector<T>& all,
                                std::vector<T>& used) {
    if (numbers[i] == kNone) {
      numbers[i] = static_cast<std::uint32_t>(used.size());
      used.push_back(all[i]);
    }
    return numbers[i];
  }

  const Mesh& mMesh;
  std::vector<std::uint32_t> mVertex, mGroup; // numbers in the part
};

/// The triangles that `partOf` gives to each of `count` parts, as meshes of their own.
template <class PartOf>
std::vector<Mesh> split(const Mesh& mesh, std::size_t count, PartOf partOf, const RunContext& ctx) {
  constexpr std::uint64_t kBytesPerTriangle = 2 * (sizeof mesh.triangles[0] + 3 * sizeof(std::uint32_t));
  ctx.requireMemory(mesh.triangles.size() * kBytesPerTriangle + 3 * mesh.positions.size() * sizeof(Vec3d) +
                        count * (sizeof(Mesh) + sizeof(std::vector<std::uint32_t>)),
                    "splitting the mesh by group");
  std::vector<std::vector<std::uint32_t>> triangles(count);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) triangles[partOf(i)].push_back(i);
  ctx.throwIfCancelled();
  Extractor extractor(mesh);
  std::vector<Mesh> parts;
  for (const auto& part : triangles) parts.push_back(extractor.extract(part));
  return parts;
}

/// A name out of a file for a message.
std::string quotedName(const std::string& name) {
  constexpr std::size_t kReadable = 60;
  return "\"" + (name.size() > kReadable ? name.substr(0, kReadable) + "..." : name) + "\"";
}

/// The bodies to come: which material each has, and which body each group of the mesh belongs to.
class BodyPlan {
public:
  BodyPlan(const Mesh& mesh, const Material& rest, int priority, const std::string& name) : mMesh(mesh), mName(name) {
    if (!mesh.triangleGroup.empty())
      for (const std::string& group : mesh.groupNames) mBodyOfName.try_emplace(group, kRest);
    mBodies.push_back({nullptr, rest, priority, name});
    mBodyOfSubstance.emplace(substance(rest, priority), kRest);
  }

  void add(const GroupMaterial& entry) {
    const auto group = mBodyOfName.find(entry.group);
    if (group == mBodyOfName.end()) failUnknown(entry.group);
    if (!mListed.insert(entry.group).second) fail("group " + quotedName(entry.group) + " is listed twice; keep one");
    const auto next = static_cast<std::uint32_t>(mBodies.size());
    const auto [body, isNew] = mBodyOfSubstance.emplace(substance(entry.material, entry.priority), next);
    if (isNew) mBodies.push_back({nullptr, entry.material, entry.priority, mName + " (" + entry.group + ")"});
    group->second = body->second;
  }

  std::vector<Body> take(const RunContext& ctx) {
    std::vector<std::uint32_t> bodyOfGroup;
    for (const std::string& group : mMesh.groupNames) bodyOfGroup.push_back(mBodyOfName.at(group));
    const auto bodyOf = [&](std::uint32_t i) { return bodyOfGroup[mMesh.triangleGroup[i]]; };
    std::vector<Mesh> parts = split(mMesh, mBodies.size(), bodyOf, ctx);
    std::vector<Body> bodies;
    for (std::size_t k = 0; k < mBodies.size(); ++k) {
      if (parts[k].empty()) continue;
      mBodies[k].mesh = std::make_shared<const Mesh>(std::move(parts[k]));
      bodies.push_back(std::move(mBodies[k]));
    }
    return bodies;
  }

private:
  static constexpr std::uint32_t kRest = 0; // the first body: all groups that are not listed

  using Substance = std::tuple<std::string, double, Rgb, Rgb, double, int>;
  static Substance substance(const Material& m, int priority) {
    return {m.name, m.index, m.attenuation, m.scattering, m.asymmetry, priority};
  }

  [[noreturn]] void fail(const std::string& what) const { throw Error(ErrorKind::Input, mName + ": " + what); }

  [[noreturn]] void failUnknown(const std::string& group) const {
    const std::string start = "no group is called " + quotedName(group);
    if (mBodyOfName.empty()) fail(start + ", the mesh has none; name materials (usemtl) or objects (o) in an OBJ file");
    fail(start + "; the nearest known one is " + quotedName(nearestWord(group, mMesh.groupNames)));
  }

  const Mesh& mMesh;
  const std::string& mName;
  std::vector<Body> mBodies;
  std::map<Substance, std::uint32_t> mBodyOfSubstance;
  std::unordered_map<std::string, std::uint32_t> mBodyOfName; // of groups; several may have one name
  std::unordered_set<std::string> mListed;
};

} // namespace

std::vector<Mesh> splitByGroup(const Mesh& mesh, const RunContext& ctx) {
  requireValid(mesh);
  if (mesh.triangleGroup.empty()) return {mesh};
  return split(
      mesh, mesh.groupNames.size(), [&](std::uint32_t i) { return mesh.triangleGroup[i]; }, ctx);
}

std::vector<Body> bodiesByGroup(std::shared_ptr<const Mesh> mesh, const Material& rest, int priority,
                                std::span<const GroupMaterial> groups, const std::string& name, const RunContext& ctx) {
  requireValid(*mesh);
  if (groups.empty()) return {{std::move(mesh), rest, priority, name}};
  BodyPlan plan(*mesh, rest, priority, name);
  for (const GroupMaterial& entry : groups) plan.add(entry);
  return plan.take(ctx);
}

} // namespace volcaustic
