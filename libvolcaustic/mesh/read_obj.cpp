// Wavefront OBJ: "Advanced Visualizer" object files, appendix B1 of its manual. Polygons and the names of materials,
// groups or objects are read; lines, points, curves, normals and texture coordinates are not.
#include "mesh/mesh_builder.h"
#include "mesh/text_cursor.h"

#include <charconv>
#include <unordered_map>
#include <vector>

namespace volcaustic {

namespace {

/// The statements that may name the groups, the one that counts most first: what encloses what matter is said by
/// materials, where a file has any.
constexpr std::string_view kGroupKeywords[] = {"usemtl", "g", "o"};

/// Two passes over the lines, because faces may refer to vertices further down, and to choose what names the groups.
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
  void noteGroupKeyword(TextCursor& cursor);
  void readFaces();
  void readFace(TextCursor& cursor);
  std::uint32_t readCorner(TextCursor& cursor);
  void enterGroup();

  const MeshSource& mSource;
  MeshBuilder mBuilder;
  std::int64_t mPositionsSoFar = 0; // in the pass over the faces: what negative indices count from
  std::vector<std::uint32_t> mCorners;
  std::size_t mGroupKeyword = std::size(kGroupKeywords); // the first of those that the file has
  std::string mGroupName;
  bool mGroupIsNew = false; // named since the last face; a group without faces is none
  std::unordered_map<std::string, std::uint32_t> mGroups;
};

void ObjReader::readPositions() {
  for (TextCursor cursor(mSource, mSource.begin); !cursor.atEnd(); cursor.nextLine()) {
    cursor.skipBlanks();
    if (!cursor.skipKeyword("v")) {
      noteGroupKeyword(cursor);
      continue;
    }
    Vec3d p;
    for (double& x : p) {
      cursor.skipBlanks();
      x = cursor.number();
    }
    mBuilder.addPosition(p); // a weight or a colour behind it is not needed
  }
}

void ObjReader::noteGroupKeyword(TextCursor& cursor) {
  for (std::size_t k = 0; k < mGroupKeyword; ++k)
    if (cursor.skipKeyword(kGroupKeywords[k])) mGroupKeyword = k;
}

void ObjReader::readFaces() {
  const std::string_view groupKeyword =
      mGroupKeyword < std::size(kGroupKeywords) ? kGroupKeywords[mGroupKeyword] : std::string_view{};
  for (TextCursor cursor(mSource, mSource.begin); !cursor.atEnd(); cursor.nextLine()) {
    cursor.skipBlanks();
    if (cursor.skipKeyword("v"))
      ++mPositionsSoFar;
    else if (cursor.skipKeyword("f"))
      readFace(cursor);
    else if (!groupKeyword.empty() && cursor.skipKeyword(groupKeyword)) {
      mGroupName = cursor.restOfLine();
      mGroupIsNew = true;
    }
  }
}

void ObjReader::readFace(TextCursor& cursor) {
  const std::uint64_t line = cursor.line();
  if (mGroupIsNew) enterGroup();
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

void ObjReader::enterGroup() {
  mGroupIsNew = false;
  if (const auto known = mGroups.find(mGroupName); known != mGroups.end()) {
    mBuilder.setGroup(known->second);
    return;
  }
  mGroups.emplace(mGroupName, mBuilder.addGroup(mGroupName));
}

} // namespace

Mesh readObj(const MeshSource& source, const RunContext& ctx) { return ObjReader(source, ctx).read(); }

} // namespace volcaustic
