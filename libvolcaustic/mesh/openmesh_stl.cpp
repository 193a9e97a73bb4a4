#include "mesh/openmesh_stl.h"

#include <mutex>
#include <OpenMesh/Core/IO/exporter/BaseExporter.hh>
#include <OpenMesh/Core/IO/writer/STLWriter.hh>
#include <OpenMesh/Core/System/omstream.hh>

namespace volcaustic {

namespace {

namespace om = OpenMesh;

/// Shows OpenMesh's writer our arrays as they are. Going through one of its own mesh types would lose faces: a
/// half-edge mesh cannot hold an edge with three of them. Of the many questions that a writer may ask, STL's asks those
/// on top.
class MeshExporter final : public om::IO::BaseExporter {
public:
  explicit MeshExporter(const Mesh& mesh) : mMesh(mesh) {}

  size_t n_vertices() const override { return mMesh.positions.size(); }
  size_t n_faces() const override { return mMesh.triangles.size(); }
  bool is_triangle_mesh() const override { return true; }
  om::Vec3f point(om::VertexHandle v) const override {
    const om::Vec3d p = pointd(v);
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
  }
  om::Vec3d pointd(om::VertexHandle v) const override {
    const Vec3d& p = mMesh.positions[static_cast<std::size_t>(v.idx())];
    return {p[0], p[1], p[2]};
  }
  bool is_point_double() const override { return true; }
  unsigned get_vhandles(om::FaceHandle f, std::vector<om::VertexHandle>& vertices) const override {
    vertices.clear();
    for (const std::uint32_t v : mMesh.triangles[static_cast<std::size_t>(f.idx())])
      vertices.emplace_back(static_cast<int>(v));
    return 3;
  }

  // Attributes that our meshes do not have.
  using Status = om::Attributes::StatusInfo;
  size_t n_edges() const override { return 0; }
  om::Vec3f normal(om::VertexHandle) const override { return om::Vec3f(0); }
  om::Vec3d normald(om::VertexHandle) const override { return om::Vec3d(0); }
  bool is_normal_double() const override { return true; }
  om::Vec3uc color(om::VertexHandle) const override { return om::Vec3uc(0); }
  om::Vec4uc colorA(om::VertexHandle) const override { return om::Vec4uc(0); }
  om::Vec3ui colori(om::VertexHandle) const override { return om::Vec3ui(0); }
  om::Vec4ui colorAi(om::VertexHandle) const override { return om::Vec4ui(0); }
  om::Vec3f colorf(om::VertexHandle) const override { return om::Vec3f(0); }
  om::Vec4f colorAf(om::VertexHandle) const override { return om::Vec4f(0); }
  om::Vec2f texcoord(om::VertexHandle) const override { return om::Vec2f(0); }
  om::Vec2f texcoord(om::HalfedgeHandle) const override { return om::Vec2f(0); }
  Status status(om::VertexHandle) const override { return {}; }
  om::HalfedgeHandle getHeh(om::FaceHandle, om::VertexHandle) const override { return om::HalfedgeHandle(); }
  unsigned get_face_texcoords(std::vector<om::Vec2f>&) const override { return 0; }
  om::Vec3f normal(om::FaceHandle) const override { return om::Vec3f(0); }
  om::Vec3d normald(om::FaceHandle) const override { return om::Vec3d(0); }
  om::Vec3uc color(om::FaceHandle) const override { return om::Vec3uc(0); }
  om::Vec4uc colorA(om::FaceHandle) const override { return om::Vec4uc(0); }
  om::Vec3ui colori(om::FaceHandle) const override { return om::Vec3ui(0); }
  om::Vec4ui colorAi(om::FaceHandle) const override { return om::Vec4ui(0); }
  om::Vec3f colorf(om::FaceHandle) const override { return om::Vec3f(0); }
  om::Vec4f colorAf(om::FaceHandle) const override { return om::Vec4f(0); }
  Status status(om::FaceHandle) const override { return {}; }
  om::Vec3uc color(om::EdgeHandle) const override { return om::Vec3uc(0); }
  om::Vec4uc colorA(om::EdgeHandle) const override { return om::Vec4uc(0); }
  om::Vec3ui colori(om::EdgeHandle) const override { return om::Vec3ui(0); }
  om::Vec4ui colorAi(om::EdgeHandle) const override { return om::Vec4ui(0); }
  om::Vec3f colorf(om::EdgeHandle) const override { return om::Vec3f(0); }
  om::Vec4f colorAf(om::EdgeHandle) const override { return om::Vec4f(0); }
  Status status(om::EdgeHandle) const override { return {}; }
  int get_halfedge_id(om::VertexHandle) override { return -1; }
  int get_halfedge_id(om::FaceHandle) override { return -1; }
  int get_next_halfedge_id(om::HalfedgeHandle) override { return -1; }
  int get_to_vertex_id(om::HalfedgeHandle) override { return -1; }
  int get_face_id(om::HalfedgeHandle) override { return -1; }
  Status status(om::HalfedgeHandle) const override { return {}; }

private:
  const Mesh& mMesh;
};

/// The writer announces every file it writes on std::clog; its log is one for the whole process.
class QuietOpenMesh {
public:
  QuietOpenMesh() : mLock(sMutex), mWasOn(::omlog().is_enabled()) { ::omlog().disable(); }
  ~QuietOpenMesh() {
    if (mWasOn) ::omlog().enable();
  }
  QuietOpenMesh(const QuietOpenMesh&) = delete;
  QuietOpenMesh& operator=(const QuietOpenMesh&) = delete;

private:
  static inline std::mutex sMutex;
  std::lock_guard<std::mutex> mLock;
  bool mWasOn;
};

} // namespace

void writeStlBinary(std::ostream& stream, const Mesh& mesh) {
  const QuietOpenMesh quiet;
  MeshExporter exporter(mesh);
  om::IO::STLWriter().write(stream, exporter, om::IO::Options::Binary);
}

} // namespace volcaustic
