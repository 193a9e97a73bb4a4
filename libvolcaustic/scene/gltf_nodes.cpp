#include "scene/gltf_nodes.h"

#include "shapes/affine.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace volcaustic {

namespace {

/// Of a unit quaternion.
Affine rotated(const std::array<double, 4>& q) {
  const auto [x, y, z, w] = q;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 0},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 0},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), 0}}};
}

Affine matrixOf(const GltfValue& value) {
  const auto m = value.numbers<16>(); // column by column
  if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
    value.fail("the last row must be 0 0 0 1; apply the transform");
  Affine a{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) a[i][j] = m[4 * j + i];
  return a;
}

std::array<double, 4> rotationOf(const GltfValue& value) {
  auto q = value.numbers<4>();
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(length > 1e-6)) value.fail("has no length; write [0, 0, 0, 1] for no rotation");
  for (double& c : q) c /= length;
  return q;
}

Affine localOf(const GltfValue& node, const GltfPose& pose) {
  const bool isAnimated = pose.translation || pose.rotation || pose.scale;
  if (const auto matrix = node.find("matrix")) {
    if (isAnimated) matrix->fail("an animated node must have translation, rotation and scale instead; export it again");
    return matrixOf(*matrix);
  }
  const auto field = [&](const auto& animated, const char* key, const auto& read, auto otherwise) {
    if (animated) return *animated;
    const auto value = node.find(key);
    return value ? read(*value) : otherwise;
  };
  const auto triple = [](const GltfValue& value) { return value.numbers<3>(); };
  const Vec3d move = field(pose.translation, "translation", triple, Vec3d{0, 0, 0});
  const Vec3d scale = field(pose.scale, "scale", triple, Vec3d{1, 1, 1});
  Affine local = rotated(field(pose.rotation, "rotation", rotationOf, std::array<double, 4>{0, 0, 0, 1}));
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) local[i][j] *= scale[j];
    local[i][3] = move[i];
  }
  return local;
}

/// Numbers of the nodes that the file's scene begins with.
std::vector<std::size_t> rootsOf(const GltfFile& file) {
  std::vector<std::size_t> roots;
  if (file.count("scenes") > 0) {
    const auto chosen = file.root().find("scene");
    const GltfValue scene = chosen ? file.resolve(*chosen, "scenes") : file.item("scenes", 0);
    const auto nodes = scene.find("nodes");
    for (std::size_t i = 0; nodes && i < nodes->size(); ++i) roots.push_back(file.indexOf((*nodes)[i], "nodes"));
    return roots;
  }
  std::vector<bool> isChild(file.count("nodes"), false);
  for (std::size_t n = 0; n < isChild.size(); ++n)
    if (const auto children = file.item("nodes", n).find("children"))
      for (std::size_t i = 0; i < children->size(); ++i) isChild[file.indexOf((*children)[i], "nodes")] = true;
  for (std::size_t n = 0; n < isChild.size(); ++n)
    if (!isChild[n]) roots.push_back(n);
  return roots;
}

double dot(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// `v` without its part along the unit vector `axis`, which is returned.
double takePart(Vec3d& v, const Vec3d& axis) {
  const double part = dot(v, axis);
  for (std::size_t i = 0; i < 3; ++i) v[i] -= part * axis[i];
  return part;
}

double takeLength(Vec3d& v) {
  const double length = std::sqrt(dot(v, v));
  for (double& x : v) x /= length;
  return length;
}

} // namespace

std::vector<GltfNode> gltfNodes(GltfFile& file, std::optional<double> seconds, GltfNotes& notes) {
  const std::map<std::size_t, GltfPose> poses =
      seconds ? gltfPoses(file, *seconds, notes) : std::map<std::size_t, GltfPose>();
  struct Waiting {
    std::size_t node;
    Affine parent;
  };
  std::vector<Waiting> waiting;
  for (const std::size_t n : rootsOf(file)) waiting.push_back({n, kIdentity});
  std::reverse(waiting.begin(), waiting.end());
  std::vector<bool> isVisited(file.count("nodes"), false);
  std::vector<GltfNode> nodes;
  while (!waiting.empty()) {
    const auto [number, parent] = waiting.back();
    waiting.pop_back();
    const GltfValue node = file.item("nodes", number);
    if (isVisited[number]) node.fail("has two parents, or is its own ancestor; nodes must make trees");
    isVisited[number] = true;
    const auto pose = poses.find(number);
    const Affine world = product(parent, localOf(node, pose == poses.end() ? GltfPose{} : pose->second));
    for (const auto& row : world)
      for (const double x : row)
        if (!(std::abs(x) <= 1e12)) node.fail("its placement in the world is beyond 1e12; scale it down");
    nodes.push_back({node, world});
    const auto children = node.find("children");
    for (std::size_t i = children ? children->size() : 0; i-- > 0;)
      waiting.push_back({file.indexOf((*children)[i], "nodes"), world});
  }
  return nodes;
}

std::optional<Placement> placementOf(const Affine& world) {
  // The columns orthogonalised one after the other (Gram-Schmidt): rotation times an upper triangle, which is scale
  // times shear.
  constexpr double kFlat = 1e-9;
  Vec3d x{world[0][0], world[1][0], world[2][0]}, y{world[0][1], world[1][1], world[2][1]},
      z{world[0][2], world[1][2], world[2][2]};
  const double longest = std::sqrt(std::max({dot(x, x), dot(y, y), dot(z, z)}));
  Placement p;
  p.translate = {world[0][3], world[1][3], world[2][3]};
  p.scale[0] = takeLength(x);
  const double xy = takePart(y, x), xz = takePart(z, x);
  p.scale[1] = takeLength(y);
  const double yz = takePart(z, y);
  p.scale[2] = takeLength(z);
  for (const double s : p.scale)
    if (!(s > kFlat * longest)) return std::nullopt;
  const auto shear = [&](double part, double scale) { return std::abs(part) > 1e-12 * longest ? part / scale : 0; };
  p.shear = {shear(xy, p.scale[0]), shear(xz, p.scale[0]), shear(yz, p.scale[1])};
  const Vec3d cross{y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]};
  if (dot(x, cross) < 0) { // a mirror: along x, so that what is left is a rotation
    for (double& c : x) c = -c;
    p.scale[0] = -p.scale[0];
  }
  constexpr double kDegrees = 180 / std::numbers::pi;
  const double flatness = std::hypot(x[0], x[1]);
  p.rotate[1] = std::atan2(-x[2], flatness) * kDegrees;
  if (flatness > 1e-9) {
    p.rotate[0] = std::atan2(y[2], z[2]) * kDegrees;
    p.rotate[2] = std::atan2(x[1], x[0]) * kDegrees;
  } else { // looking along the axis: x and z turn about the same line, and z does it alone
    p.rotate[2] = std::atan2(-y[0], y[1]) * kDegrees;
  }
  return p;
}

} // namespace volcaustic
