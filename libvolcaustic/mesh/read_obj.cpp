// Wavefront OBJ: "Advanced Visualizer" object files, appendix B1 of its manual. Polygons and the names of materials,
// groups or objects are read; lines, points, curves, normals and texture coordinates are not.
#include "core/parallel.h"
#include "mesh/mesh_builder.h"
#include "mesh/text_cursor.h"

#include <algorithm>
#include <charconv>
#include <exception>
#include <unordered_map>
#include <vector>

namespace volcaustic {

namespace {

/// The statements that may name the groups, the one that counts most first: what encloses what matter is said by
/// materials, where a file has any.
constexpr std::string_view kGroupKeywords[] = {"usemtl", "g", "o"};

/// The text from one line's start to another's, and what was found there.
struct Piece {
  Piece(std::size_t first, std::size_t last) : begin(first), end(last) {}

  std::size_t begin, end;
  std::uint64_t firstLine = 1, lineCount = 0;
  std::vector<Vec3d> positions;
  std::size_t positionsBefore = 0;                      ///< in the pieces before
  std::size_t groupKeyword = std::size(kGroupKeywords); ///< the first of those that the piece has
  std::vector<std::uint32_t> corners, faceSizes;
  struct GroupName {
    std::size_t face; ///< the first that it may belong to; as many as the piece has: a face further down
    std::string_view name;
  };
  std::vector<GroupName> groupNames; ///< the last before each face: a group without faces is none
  std::exception_ptr error;
};

/// Whether the line that ends with the '\n' at `newline` goes on in the next one.
bool continues(std::string_view text, std::size_t newline) {
  const std::size_t last = text.find_last_not_of(" \t\v\f\r", newline == 0 ? 0 : newline - 1);
  return last != std::string_view::npos && text[last] == '\\';
}

std::vector<Piece> piecesOf(const MeshSource& source) {
  constexpr std::size_t kPieceBytes = 1 << 18;
  const std::string_view text = source.content;
  std::vector<Piece> pieces;
  for (std::size_t begin = source.begin; begin < text.size();) {
    std::size_t newline = text.find('\n', std::min(begin + kPieceBytes, text.size()));
    while (newline != std::string_view::npos && continues(text, newline)) newline = text.find('\n', newline + 1);
    const std::size_t end = newline == std::string_view::npos ? text.size() : newline + 1;
    pieces.emplace_back(begin, end);
    begin = end;
  }
  return pieces;
}

/// Two passes over the lines, because faces may refer to vertices further down, and to choose what names the groups.
/// Both read many pieces at once; what is wrong is told as if there was one.
class ObjReader {
public:
  ObjReader(const MeshSource& source, const RunContext& ctx)
      : mSource(source), mCtx(ctx), mBuilder(source, ctx), mPieces(piecesOf(source)) {}

  Mesh read() {
    forPieces([this](Piece& piece) { readPositions(piece); });
    if (const auto failed = std::find_if(mPieces.begin(), mPieces.end(), hasFailed); failed != mPieces.end())
      repeat(*failed);
    gatherPositions();
    forPieces([this](Piece& piece) { readFaces(piece); });
    for (Piece& piece : mPieces) {
      if (piece.error) std::rethrow_exception(piece.error);
      gatherFaces(piece);
    }
    return mBuilder.take();
  }

private:
  static bool hasFailed(const Piece& piece) { return piece.error != nullptr; }
  template <class Body>
  void forPieces(const Body& body) {
    parallelFor(static_cast<std::int64_t>(mPieces.size()), 1, mCtx, [&](std::int64_t i, std::int64_t, int) {
      try {
        body(mPieces[i]);
      } catch (...) {
        mPieces[i].error = std::current_exception();
      }
    });
  }
  void readPositions(Piece& piece);
  [[noreturn]] void repeat(Piece& failed);
  void gatherPositions();
  void readFaces(Piece& piece);
  void readFace(TextCursor& cursor, std::size_t positionsSoFar, Piece& piece);
  std::uint32_t readCorner(TextCursor& cursor, std::size_t positionsSoFar) const;
  void gatherFaces(const Piece& piece);
  [[nodiscard]] std::uint64_t lineOfFace(const Piece& piece, std::size_t face) const;
  void enterGroup();

  const MeshSource& mSource;
  const RunContext& mCtx;
  MeshBuilder mBuilder;
  std::vector<Piece> mPieces;
  std::string_view mGroupKeyword; // what names the groups; empty where nothing does
  std::string_view mGroupName;
  bool mGroupIsNew = false; // named since the last face
  std::unordered_map<std::string_view, std::uint32_t> mGroups;
};

void ObjReader::readPositions(Piece& piece) {
  TextCursor cursor(mSource, piece.begin, piece.end, piece.firstLine);
  for (; !cursor.atEnd(); cursor.nextLine()) {
    cursor.skipBlanks();
    if (!cursor.skipKeyword("v")) {
      for (std::size_t k = 0; k < piece.groupKeyword; ++k)
        if (cursor.skipKeyword(kGroupKeywords[k])) piece.groupKeyword = k;
      continue;
    }
    Vec3d p;
    for (double& x : p) {
      cursor.skipBlanks();
      x = cursor.number();
    }
    piece.positions.push_back(p); // a weight or a colour behind it is not needed
  }
  piece.lineCount = cursor.line() - piece.firstLine;
}

/// Reads it again where its lines are counted from the first of the file, for the message. Those before it are whole.
void ObjReader::repeat(Piece& failed) {
  for (const Piece* before = mPieces.data(); before != &failed; ++before) failed.firstLine += before->lineCount;
  readPositions(failed);
  std::rethrow_exception(failed.error); // which has nothing to do with the text
}

void ObjReader::gatherPositions() {
  std::size_t count = 0, keyword = std::size(kGroupKeywords);
  std::uint64_t line = 1;
  for (Piece& piece : mPieces) {
    piece.firstLine = line;
    piece.positionsBefore = count;
    line += piece.lineCount;
    count += piece.positions.size();
    keyword = std::min(keyword, piece.groupKeyword);
  }
  if (keyword < std::size(kGroupKeywords)) mGroupKeyword = kGroupKeywords[keyword];
  mBuilder.reserve(count, 0);
  for (Piece& piece : mPieces) {
    for (const Vec3d& p : piece.positions) mBuilder.addPosition(p);
    piece.positions = {};
  }
}

void ObjReader::readFaces(Piece& piece) {
  std::size_t positionsSoFar = piece.positionsBefore; // what negative indices count from
  for (TextCursor cursor(mSource, piece.begin, piece.end, piece.firstLine); !cursor.atEnd(); cursor.nextLine()) {
    cursor.skipBlanks();
    if (cursor.skipKeyword("v"))
      ++positionsSoFar;
    else if (cursor.skipKeyword("f"))
      readFace(cursor, positionsSoFar, piece);
    else if (!mGroupKeyword.empty() && cursor.skipKeyword(mGroupKeyword)) {
      const std::size_t face = piece.faceSizes.size();
      if (piece.groupNames.empty() || piece.groupNames.back().face != face) piece.groupNames.push_back({face, {}});
      piece.groupNames.back().name = cursor.restOfLine();
    }
  }
}

void ObjReader::readFace(TextCursor& cursor, std::size_t positionsSoFar, Piece& piece) {
  const std::uint64_t line = cursor.line();
  const std::size_t first = piece.corners.size();
  for (cursor.skipBlanks(); !cursor.atLineEnd(); cursor.skipBlanks())
    piece.corners.push_back(readCorner(cursor, positionsSoFar));
  const std::size_t count = piece.corners.size() - first;
  if (count < 3) mSource.failAtLine(line, "a face needs three corners or more, this one has " + std::to_string(count));
  piece.faceSizes.push_back(static_cast<std::uint32_t>(count));
}

/// "v", "v/t", "v//n" or "v/t/n", each a whole number; some exporters leave slashes behind ("1//").
std::uint32_t ObjReader::readCorner(TextCursor& cursor, std::size_t positionsSoFar) const {
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
  const std::int64_t position = index > 0 ? index - 1 : static_cast<std::int64_t>(positionsSoFar) + index;
  if (index == 0 || position < 0 || position >= count)
    cursor.fail("face corner " + quoted(token) + " refers to no vertex; the file has " + std::to_string(count) +
                " and counts from 1");
  return static_cast<std::uint32_t>(position);
}

void ObjReader::gatherFaces(const Piece& piece) {
  auto name = piece.groupNames.begin();
  const std::uint32_t* corners = piece.corners.data();
  for (std::size_t face = 0; face <= piece.faceSizes.size(); ++face) {
    if (name != piece.groupNames.end() && name->face == face) {
      mGroupName = name++->name;
      mGroupIsNew = true;
    }
    if (face == piece.faceSizes.size()) break;
    if (mGroupIsNew) enterGroup();
    const std::uint32_t count = piece.faceSizes[face];
    if (!mBuilder.addPolygon({corners, count}))
      mSource.failAtLine(lineOfFace(piece, face), "a face of " + std::to_string(count) +
                                                      " corners that is not convex is too large; triangulate it on "
                                                      "export");
    corners += count;
  }
}

std::uint64_t ObjReader::lineOfFace(const Piece& piece, std::size_t face) const {
  TextCursor cursor(mSource, piece.begin, piece.end, piece.firstLine);
  for (std::size_t faces = 0;; cursor.nextLine()) {
    cursor.skipBlanks();
    if (cursor.skipKeyword("f") && faces++ == face) return cursor.line();
  }
}

void ObjReader::enterGroup() {
  mGroupIsNew = false;
  if (const auto known = mGroups.find(mGroupName); known != mGroups.end()) {
    mBuilder.setGroup(known->second);
    return;
  }
  mGroups.emplace(mGroupName, mBuilder.addGroup(std::string(mGroupName)));
}

} // namespace

Mesh readObj(const MeshSource& source, const RunContext& ctx) { return ObjReader(source, ctx).read(); }

} // namespace volcaustic
