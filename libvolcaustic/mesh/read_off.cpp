// Object File Format of Geomview (Geomview manual, section "OFF Files"), text and binary, with the prefixes ST, C and
// N. Texture coordinates, colours and normals are skipped.
#include "mesh/mesh_builder.h"
#include "mesh/text_cursor.h"

#include <bit>
#include <cmath>
#include <cstring>

namespace volcaustic {

namespace {

struct OffKeyword {
  bool texture = false, colour = false, normal = false;
  bool otherDimension = false; ///< "4OFF", "nOFF"
  std::size_t length = 0;
};

OffKeyword parseKeyword(std::string_view text) {
  OffKeyword k;
  std::size_t at = 0;
  const auto take = [&](std::string_view prefix) {
    if (text.substr(at, prefix.size()) != prefix) return false;
    at += prefix.size();
    return true;
  };
  k.texture = take("ST");
  k.colour = take("C");
  k.normal = take("N");
  k.otherDimension = take("4");
  k.otherDimension |= take("n");
  constexpr std::string_view kMayFollow = " \t\r\n#0123456789"; // some writers put the first count right behind it
  if (!take("OFF") || (at != text.size() && kMayFollow.find(text[at]) == kMayFollow.npos)) return {};
  k.length = at;
  return k;
}

std::string tooManyRows(const char* what, std::int64_t count) {
  return "announces " + std::to_string(count) + " " + what +
         ", more than the rest of the file can hold; it is truncated or damaged";
}

class OffTextReader {
public:
  OffTextReader(const MeshSource& source, std::size_t begin, std::uint64_t line, const RunContext& ctx)
      : mCursor(source, begin, line), mBuilder(source, ctx) {}

  /// Every vertex and every face starts on a line of its own; what follows it on that line is a colour or the like.
  Mesh read() {
    const std::int64_t vertices = readCount("vertices", 6), faces = readCount("faces", 8);
    mCursor.nextLine(); // the number of edges, which nobody needs
    mBuilder.reserve(static_cast<std::uint64_t>(vertices), static_cast<std::uint64_t>(faces));
    for (std::int64_t i = 0; i < vertices; ++i) readVertex();
    for (std::int64_t i = 0; i < faces; ++i) readFace();
    return mBuilder.take();
  }

private:
  std::int64_t nextInteger() {
    mCursor.skipBlanksAndLines();
    return mCursor.integer();
  }
  std::int64_t readCount(const char* what, std::size_t minimumRow) {
    const std::int64_t count = nextInteger();
    if (count < 0 || static_cast<std::size_t>(count) > mCursor.remaining() / minimumRow + 1)
      mCursor.fail(tooManyRows(what, count));
    return count;
  }
  void readVertex();
  void readFace();

  TextCursor mCursor;
  MeshBuilder mBuilder;
  std::vector<std::uint32_t> mCorners;
};

void OffTextReader::readVertex() {
  Vec3d p;
  for (double& x : p) {
    mCursor.skipBlanksAndLines();
    x = mCursor.number();
  }
  mBuilder.addPosition(p);
  mCursor.nextLine();
}

void OffTextReader::readFace() {
  const std::int64_t corners = nextInteger();
  if (corners < 3) mCursor.fail("a face needs three corners or more, this one has " + std::to_string(corners));
  mCorners.clear();
  for (std::int64_t k = 0; k < corners; ++k) {
    const std::int64_t index = nextInteger();
    if (index < 0 || index >= static_cast<std::int64_t>(mBuilder.positionCount()))
      mCursor.fail("a face refers to vertex " + std::to_string(index) + "; the file has " +
                   std::to_string(mBuilder.positionCount()) + " and counts from 0");
    mCorners.push_back(static_cast<std::uint32_t>(index));
  }
  if (!mBuilder.addPolygon(mCorners))
    mCursor.fail("a face of " + std::to_string(corners) +
                 " corners that is not convex is too large; triangulate it on export");
  mCursor.nextLine();
}

/// The manual says big-endian, with a number of colour components behind each face. Writers in use (pmp-library) leave
/// the machine's order and drop that number, so both are told apart by what fits the file.
class OffBinaryReader {
public:
  OffBinaryReader(const MeshSource& source, std::size_t begin, const OffKeyword& keyword, const RunContext& ctx)
      : mSource(source)
      , mAt(begin)
      , mVertexBytes(4 * (3 + (keyword.normal ? 3 : 0) + (keyword.colour ? 4 : 0) + (keyword.texture ? 2 : 0)))
      , mBuilder(source, ctx) {}

  Mesh read() {
    readCounts();
    mBuilder.reserve(mVertices, mFaces);
    for (std::uint32_t i = 0; i < mVertices; ++i) readVertex();
    const bool colours = facesEndWithFile(true);
    if (!colours && !facesEndWithFile(false)) mSource.failAtByte(mAt, "the faces do not fill the rest of the file");
    for (std::uint32_t i = 0; i < mFaces; ++i) readFace(colours);
    return mBuilder.take();
  }

private:
  static constexpr std::size_t kCountsBytes = 12, kMinimumFaceBytes = 16;

  std::uint32_t word(std::size_t at) const {
    std::uint32_t value = 0;
    std::memcpy(&value, mSource.content.data() + at, sizeof value);
    return (std::endian::native == std::endian::big) == mBigEndian ? value : __builtin_bswap32(value);
  }
  std::size_t remaining() const { return mSource.content.size() - mAt; }
  void readCounts();
  void readVertex();
  [[nodiscard]] bool facesEndWithFile(bool colours) const;
  void readFace(bool colours);

  const MeshSource& mSource;
  std::size_t mAt, mVertexBytes;
  bool mBigEndian = true;
  std::uint32_t mVertices = 0, mFaces = 0;
  MeshBuilder mBuilder;
  std::vector<std::uint32_t> mCorners;
};

void OffBinaryReader::readCounts() {
  if (remaining() < kCountsBytes) mSource.failAtByte(mAt, "the file ends within its counts; it looks truncated");
  for (const bool bigEndian : {true, false}) {
    mBigEndian = bigEndian;
    mVertices = word(mAt), mFaces = word(mAt + 4);
    if (mVertices * std::uint64_t{mVertexBytes} + mFaces * std::uint64_t{kMinimumFaceBytes} <=
        remaining() - kCountsBytes) {
      mAt += kCountsBytes;
      return;
    }
  }
  mSource.failAtByte(mAt, "the counts of vertices and faces are more than the rest of the file can hold; it is "
                          "truncated or damaged");
}

void OffBinaryReader::readVertex() {
  Vec3d p;
  for (int k = 0; k < 3; ++k) p[k] = std::bit_cast<float>(word(mAt + 4 * k));
  for (const double x : p)
    if (!std::isfinite(x)) mSource.failAtByte(mAt, "a coordinate is not a finite number");
  mBuilder.addPosition(p);
  mAt += mVertexBytes;
}

bool OffBinaryReader::facesEndWithFile(bool colours) const {
  std::size_t at = mAt;
  const std::size_t end = mSource.content.size();
  const auto skipList = [&] {
    if (end - at < 4) return false;
    const std::size_t bytes = 4 + std::size_t{4} * word(at);
    if (end - at < bytes) return false;
    at += bytes;
    return true;
  };
  for (std::uint32_t i = 0; i < mFaces; ++i)
    if (!skipList() || (colours && !skipList())) return false;
  return at == end;
}

void OffBinaryReader::readFace(bool colours) {
  const std::uint32_t corners = word(mAt);
  if (corners < 3)
    mSource.failAtByte(mAt, "a face needs three corners or more, this one has " + std::to_string(corners));
  mCorners.clear();
  for (std::uint32_t k = 0; k < corners; ++k) {
    const std::uint32_t index = word(mAt + 4 + 4 * std::size_t{k});
    if (index >= mVertices)
      mSource.failAtByte(mAt, "a face refers to vertex " + std::to_string(index) + "; the file has " +
                                  std::to_string(mVertices) + " and counts from 0");
    mCorners.push_back(index);
  }
  if (!mBuilder.addPolygon(mCorners))
    mSource.failAtByte(mAt, "a face of " + std::to_string(corners) +
                                " corners that is not convex is too large; triangulate it on export");
  mAt += 4 + 4 * std::size_t{corners};
  if (colours) mAt += 4 + 4 * std::size_t{word(mAt)};
}

} // namespace

std::size_t offKeywordLength(std::string_view text) { return parseKeyword(text).length; }

Mesh readOff(const MeshSource& source, const RunContext& ctx) {
  TextCursor cursor(source, source.begin);
  cursor.skipBlanksAndLines();
  const std::string_view text = std::string_view(source.content).substr(cursor.offset());
  const OffKeyword keyword = parseKeyword(text); // a file with the extension .off may come without one
  if (keyword.otherDimension) cursor.fail("only three-dimensional OFF files are read, not 4OFF or nOFF");
  const std::size_t begin = cursor.offset() + keyword.length;
  if (keyword.length && text.substr(keyword.length).starts_with(" BINARY")) {
    cursor.nextLine();
    return OffBinaryReader(source, cursor.offset(), keyword, ctx).read();
  }
  return OffTextReader(source, begin, cursor.line(), ctx).read();
}

} // namespace volcaustic
