// Wavefront OBJ: "Advanced Visualizer" object files, appendix B1 of its manual. Polygons and material names are read;
// lines, points, curves, normals and texture coordinates are not.
#include "mesh/mesh_builder.h"
#include "mesh/text_cursor.h"

#include <charconv>
#include <unordered_map>
#include <vector>

namespace volcaustic {

namespace {

/// Two passes over the lines, because faces may refer to vertices further down.
class ObjReader {
public:
  ObjReader(const MeshSource& source, const RunContext& ctx) : mSource(source), mBuilder(source, ctx) {}

  Mesh read() {
    readPositions();
    readFaces();
    return mBuilder.take();
  }

private:
  void readPositions();
  void readFaces();
  void readFace(TextCursor& cursor);
  std::uint32_t readCorner(TextCursor& cursor);
  void useMaterial(std::string name);

  const MeshSource& mSource;
  MeshBuilder mBuilder;
  std::int64_t mPositionsSoFar = 0; // in the pass over the faces: what negative indices count from
  std::vector<std::uint32_t> mCorners;
  std::unordered_map<std::string, std::uint32_t> mGroups;
};

void ObjReader::readPositions() {
  for (TextCursor cursor(mSource, mSource.begin); !cursor.atEnd(); cursor.nextLine()) {
    cursor.skipBlanks();
    if (!cursor.skipKeyword("v")) continue;
    Vec3d p;
    for (double& x : p) {
      cursor.skipBlanks();
      x = cursor.number();
    }
    mBuilder.addPosition(p); // a weight or a colour behind it is not needed
  }
}

void ObjReader::readFaces() {
  for (TextCursor cursor(mSource, mSource.begin); !cursor.atEnd(); cursor.nextLine()) {
    cursor.skipBlanks();
    if (cursor.skipKeyword("v"))
      ++mPositionsSoFar;
    else if (cursor.skipKeyword("f"))
      readFace(cursor);
    else if (cursor.skipKeyword("usemtl"))
      useMaterial(std::string(cursor.restOfLine()));
  }
}

void ObjReader::readFace(TextCursor& cursor) {
  const std::uint64_t line = cursor.line();
  mCorners.clear();
  for (cursor.skipBlanks(); !cursor.atLineEnd(); cursor.skipBlanks()) mCorners.push_back(readCorner(cursor));
  if (mCorners.size() < 3)
    mSource.failAtLine(line, "a face needs three corners or more, this one has " + std::to_string(mCorners.size()));
  if (!mBuilder.addPolygon(mCorners))
    mSource.failAtLine(line, "a face of " + std::to_string(mCorners.size()) +
                                 " corners that is not convex is too large; triangulate it on export");
}

/// "v", "v/t", "v//n" or "v/t/n", each a whole number; some exporters leave slashes behind ("1//").
std::uint32_t ObjReader::readCorner(TextCursor& cursor) {
  const std::string_view token = cursor.token();
  std::int64_t index = 0;
  const char* end = token.data() + token.size();
  auto [p, error] = std::from_chars(token.data(), end, index);
  int slashes = 0;
  while (error == std::errc{} && p != end && *p == '/' && ++slashes <= 2) {
    std::int64_t unused = 0;
    const auto result = std::from_chars(++p, end, unused);
    if (result.ec == std::errc::result_out_of_range) error = result.ec;
    p = result.ptr;
  }
  if (error != std::errc{} || p != end)
    cursor.fail("face corner " + quoted(token) + " is malformed; it must be v, v/t, v//n or v/t/n in whole numbers");
  const auto count = static_cast<std::int64_t>(mBuilder.positionCount());
  const std::int64_t position = index > 0 ? index - 1 : mPositionsSoFar + index;
  if (index == 0 || position < 0 || position >= count)
    cursor.fail("face corner " + quoted(token) + " refers to no vertex; the file has " + std::to_string(count) +
                " and counts from 1");
  return static_cast<std::uint32_t>(position);
}

void ObjReader::useMaterial(std::string name) {
  if (const auto known = mGroups.find(name); known != mGroups.end()) {
    mBuilder.setGroup(known->second);
    return;
  }
  const std::uint32_t group = mBuilder.addGroup(name);
  mGroups.emplace(std::move(name), group);
}

} // namespace

Mesh readObj(const MeshSource& source, const RunContext& ctx) { return ObjReader(source, ctx).read(); }

} // namespace volcaustic
