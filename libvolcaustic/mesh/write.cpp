// Meshes into files. Coordinates are written with std::to_chars, the shortest text that reads back to the same double.
#include "core/atomic_file.h"
#include "mesh/openmesh_stl.h"
#include "mesh/validate.h"
#include "volcaustic/error.h"
#include "volcaustic/mesh.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace volcaustic {

namespace {

static_assert(std::endian::native == std::endian::little, "binary PLY is written as it lies in memory");

/// Gathers pieces of a file and hands them to a stream in large blocks.
class Output {
public:
  Output(std::ostream& stream, const RunContext& ctx) : mStream(stream), mCtx(ctx) {}

  Output& operator<<(std::string_view text) {
    mBuffer += text;
    if (mBuffer.size() >= kBlock) flush();
    return *this;
  }
  Output& operator<<(double value) { return number(value); }
  Output& operator<<(std::size_t value) { return number(value); }
  Output& operator<<(std::uint32_t value) { return number(value); }
  /// "x y z"
  Output& operator<<(const Vec3d& p) { return *this << p[0] << " " << p[1] << " " << p[2]; }
  template <class T>
  Output& raw(const T& value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    return *this << std::string_view(bytes, sizeof value);
  }
  void flush() {
    mCtx.throwIfCancelled();
    mStream.write(mBuffer.data(), static_cast<std::streamsize>(mBuffer.size()));
    mBuffer.clear();
  }

private:
  static constexpr std::size_t kBlock = 1 << 20;

  template <class T>
  Output& number(T value) {
    char text[32];
    return *this << std::string_view(text, std::to_chars(text, text + sizeof text, value).ptr - text);
  }

  std::ostream& mStream;
  const RunContext& mCtx;
  std::string mBuffer;
};

/// A name that ends with its line.
std::string oneLine(std::string name) {
  for (char& c : name)
    if (c == '\n' || c == '\r') c = ' ';
  return name.empty() ? "default" : name;
}

void writeObj(Output& out, const Mesh& mesh) {
  for (const Vec3d& p : mesh.positions) out << "v " << p << "\n";
  // Triangles ahead of the first named group need no usemtl.
  std::string_view current;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!mesh.triangleGroup.empty()) {
      const std::string& name = mesh.groupNames[mesh.triangleGroup[i]];
      if (name != current) out << "usemtl " << oneLine(name) << "\n";
      current = name;
    }
    const auto& [a, b, c] = mesh.triangles[i];
    out << "f " << std::size_t{a} + 1 << " " << std::size_t{b} + 1 << " " << std::size_t{c} + 1 << "\n";
  }
}

void writeOff(Output& out, const Mesh& mesh) {
  out << "OFF\n" << mesh.positions.size() << " " << mesh.triangles.size() << " 0\n";
  for (const Vec3d& p : mesh.positions) out << p << "\n";
  for (const auto& [a, b, c] : mesh.triangles) out << "3 " << a << " " << b << " " << c << "\n";
}

bool fitsFloats(const Mesh& mesh) {
  return std::all_of(mesh.positions.begin(), mesh.positions.end(), [](const Vec3d& p) {
    return std::all_of(p.begin(), p.end(), [](double x) {
      return std::abs(x) <= std::numeric_limits<float>::max() && static_cast<double>(static_cast<float>(x)) == x;
    });
  });
}

void writePly(Output& out, const Mesh& mesh, bool binary) {
  const bool floats = fitsFloats(mesh); // what came from a file of floats goes into one
  const std::string_view type = floats ? "float" : "double";
  out << "ply\nformat " << (binary ? "binary_little_endian" : "ascii") << " 1.0\ncomment volcaustic\nelement vertex "
      << mesh.positions.size();
  for (const std::string_view axis : {"x", "y", "z"}) out << "\nproperty " << type << " " << axis;
  out << "\nelement face " << mesh.triangles.size() << "\nproperty list uchar uint vertex_indices\nend_header\n";
  if (!binary) {
    for (const Vec3d& p : mesh.positions) out << p << "\n";
    for (const auto& [a, b, c] : mesh.triangles) out << "3 " << a << " " << b << " " << c << "\n";
    return;
  }
  for (const Vec3d& p : mesh.positions)
    if (floats)
      out.raw(Vec3f{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    else
      out.raw(p);
  for (const auto& triangle : mesh.triangles) out.raw(std::uint8_t{3}).raw(triangle);
}

Vec3d unitNormal(const Vec3d& p, const Vec3d& q, const Vec3d& r) {
  const Vec3d u{q[0] - p[0], q[1] - p[1], q[2] - p[2]}, v{r[0] - p[0], r[1] - p[1], r[2] - p[2]};
  const Vec3d n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double length = std::hypot(n[0], n[1], n[2]);
  if (!(length > 0) || !std::isfinite(length)) return {0, 0, 0};
  return {n[0] / length, n[1] / length, n[2] / length};
}

/// A solid for each run of triangles of one group.
void writeStlText(Output& out, const Mesh& mesh) {
  const bool groups = !mesh.triangleGroup.empty();
  const auto nameOf = [&](std::size_t i) {
    return groups ? oneLine(mesh.groupNames[mesh.triangleGroup[i]]) : std::string("volcaustic");
  };
  std::string name;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i == 0 || (groups && mesh.triangleGroup[i] != mesh.triangleGroup[i - 1])) {
      if (i > 0) out << "endsolid " << name << "\n";
      name = nameOf(i);
      out << "solid " << name << "\n";
    }
    const auto& [a, b, c] = mesh.triangles[i];
    const Vec3d &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
    out << "facet normal " << unitNormal(p, q, r) << "\nouter loop\nvertex " << p << "\nvertex " << q << "\nvertex "
        << r << "\nendloop\nendfacet\n";
  }
  out << (mesh.empty() ? "solid volcaustic\nendsolid volcaustic\n" : "endsolid " + name + "\n");
}

/// Binary STL has 32-bit floats: refuses what is beyond their range, and warns where they cost the shape.
void requireFloats(const std::string& name, const Mesh& mesh, const RunContext& ctx) {
  constexpr double kVisible = 1e-5; // of the longest side: a tenth of a voxel at 10000 of them
  const Box box = bounds(mesh);
  const double longest = std::max({box.max[0] - box.min[0], box.max[1] - box.min[1], box.max[2] - box.min[2]});
  double moved = 0;
  for (const Vec3d& p : mesh.positions)
    for (const double x : p) {
      if (std::abs(x) > std::numeric_limits<float>::max())
        throw Error(ErrorKind::Input, name + ": a coordinate is beyond the 32-bit floats of a binary STL; write a PLY");
      moved = std::max(moved, std::abs(static_cast<double>(static_cast<float>(x)) - x));
    }
  if (moved > kVisible * longest)
    ctx.warn(name +
             ": the 32-bit floats of a binary STL move vertices of this mesh, which is far from the origin, by up "
             "to " +
             std::to_string(moved / longest) + " of its size; write a PLY or a text STL");
}

void writeContent(std::ostream& stream, const std::string& name, std::string_view extension, const Mesh& mesh,
                  bool binary, const RunContext& ctx) {
  Output out(stream, ctx);
  if (extension == ".obj")
    writeObj(out, mesh);
  else if (extension == ".ply")
    writePly(out, mesh, binary);
  else if (extension == ".off")
    writeOff(out, mesh);
  else if (!binary)
    writeStlText(out, mesh);
  else {
    requireFloats(name, mesh, ctx);
    writeStlBinary(stream, mesh);
  }
  out.flush();
}

} // namespace

void writeMesh(const std::filesystem::path& path, const Mesh& mesh, const MeshWriteOptions& options,
               const RunContext& ctx) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  constexpr std::string_view kKnown[] = {".obj", ".ply", ".stl", ".off"};
  if (std::find(std::begin(kKnown), std::end(kKnown), extension) == std::end(kKnown))
    throw Error(ErrorKind::Usage,
                path.string() + ": no mesh format has the extension '" + extension + "'; use .obj, .ply, .stl or .off");
  requireValid(mesh);
  AtomicFile file(path);
  std::ofstream stream(file.path(), std::ios::binary);
  writeContent(stream, path.string(), extension, mesh, options.binary, ctx);
  stream.close();
  if (!stream) throw Error(ErrorKind::File, path.string() + ": cannot be written whole; check the space that is left");
  file.commit();
}

} // namespace volcaustic
