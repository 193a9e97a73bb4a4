// STL, text and binary: 3D Systems' StereoLithography Interface Specification, 1989. Corners at the same position
// become one vertex; facet normals are not read, the winding says it all.
#include "mesh/mesh_builder.h"
#include "mesh/text_cursor.h"
#include "mesh/weld.h"

#include <bit>
#include <cmath>
#include <cstring>

namespace volcaustic {

namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies in the file");

class StlTextReader {
public:
  StlTextReader(const MeshSource& source, const RunContext& ctx)
      : mCursor(source, source.begin), mBuilder(source, ctx), mManySolids(countSolids(source) > 1) {}

  Mesh read() {
    for (mCursor.skipBlanksAndLines(); !mCursor.atEnd(); mCursor.skipBlanksAndLines()) readSolid();
    mBuilder.setPositions(mWelder.takePositions());
    return mBuilder.take();
  }

private:
  static int countSolids(const MeshSource& source);
  void readSolid();
  void readFacet();
  void expect(std::string_view keyword);

  TextCursor mCursor;
  MeshBuilder mBuilder;
  PositionWelder mWelder;
  std::vector<std::uint32_t> mCorners;
  bool mManySolids;
};

/// Counts until it is known that there are several.
int StlTextReader::countSolids(const MeshSource& source) {
  int solids = 0;
  for (TextCursor cursor(source, source.begin); !cursor.atEnd() && solids < 2; cursor.nextLine()) {
    cursor.skipBlanks();
    if (cursor.skipKeyword("solid")) ++solids;
  }
  return solids;
}

void StlTextReader::expect(std::string_view keyword) {
  mCursor.skipBlanksAndLines();
  if (mCursor.skipKeyword(keyword)) return;
  if (mCursor.atEnd())
    mCursor.fail("the file ends where '" + std::string(keyword) + "' is expected; it looks truncated");
  mCursor.fail("expected '" + std::string(keyword) + "', found " + quoted(mCursor.token()));
}

void StlTextReader::readSolid() {
  expect("solid");
  const std::string_view name = mCursor.restOfLine();
  if (mManySolids) mBuilder.addGroup(std::string(name));
  for (mCursor.skipBlanksAndLines(); !mCursor.skipKeyword("endsolid"); mCursor.skipBlanksAndLines()) readFacet();
  mCursor.nextLine(); // the name, once more
}

void StlTextReader::readFacet() {
  expect("facet");
  mCursor.nextLine(); // the normal
  expect("outer");
  expect("loop");
  mCorners.clear();
  for (mCursor.skipBlanksAndLines(); !mCursor.skipKeyword("endloop"); mCursor.skipBlanksAndLines()) {
    expect("vertex");
    Vec3d p;
    for (double& x : p) {
      mCursor.skipBlanks();
      x = mCursor.number();
    }
    mCorners.push_back(mWelder.add(p));
  }
  if (mCorners.size() != 3) mCursor.fail("a facet has three vertices, this one has " + std::to_string(mCorners.size()));
  expect("endfacet");
  mBuilder.addTriangle(mCorners[0], mCorners[1], mCorners[2]);
}

} // namespace

std::uint32_t binaryStlTriangleCount(std::string_view content) {
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + 80, sizeof count);
  return count;
}

Mesh readStlText(const MeshSource& source, const RunContext& ctx) { return StlTextReader(source, ctx).read(); }

Mesh readStlBinary(const MeshSource& source, const RunContext& ctx) {
  const std::string& content = source.content;
  if (content.size() < kBinaryStlHeaderSize)
    source.fail("is too short for an STL file, which starts with 'solid' or an 84-byte header");
  const std::uint32_t count = binaryStlTriangleCount(content);
  const std::uint64_t present = (content.size() - kBinaryStlHeaderSize) / kBinaryStlTriangleSize;
  if (count != present)
    source.failAtByte(80, "announces " + std::to_string(count) + " triangles but the file holds " +
                              std::to_string(present) + "; it is truncated or not an STL file");
  ctx.requireMemory(content.size() + PositionWelder::bytesFor(3 * std::uint64_t{count}) +
                        std::uint64_t{count} * sizeof(std::array<std::uint32_t, 3>),
                    source.name);
  MeshBuilder builder(source, ctx);
  builder.reserve(0, count);
  PositionWelder welder(count / 2);
  for (std::uint32_t t = 0; t < count; ++t) {
    constexpr std::size_t kNormalSize = 12;
    const std::size_t offset = kBinaryStlHeaderSize + std::size_t{t} * kBinaryStlTriangleSize + kNormalSize;
    std::array<float, 9> x;
    std::memcpy(x.data(), content.data() + offset, sizeof x);
    for (const float c : x)
      if (!std::isfinite(c))
        source.failAtByte(offset, "triangle " + std::to_string(t) + " has a coordinate that is not a finite number");
    const std::uint32_t a = welder.add({x[0], x[1], x[2]}), b = welder.add({x[3], x[4], x[5]}),
                        c = welder.add({x[6], x[7], x[8]});
    builder.addTriangle(a, b, c);
  }
  builder.setPositions(welder.takePositions());
  return builder.take();
}

} // namespace volcaustic
