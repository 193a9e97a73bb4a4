// The body of a PLY file, text or binary: element `vertex`, then `face` (polygons) and `tristrips` (triangle strips
// with -1 between them, as Stanford's and Cyberware's tools write them). Everything else is skipped.
#include "mesh/mesh_builder.h"
#include "mesh/ply_header.h"
#include "mesh/text_cursor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace volcaustic {

namespace {

/// Values of a text body, wherever the lines break.
class TextInput {
public:
  TextInput(const MeshSource& source, const PlyHeader& header) : mCursor(source, header.bodyOffset, header.bodyLine) {}

  double number(PlyType) {
    mCursor.skipBlanksAndLines();
    return mCursor.number();
  }
  std::int64_t integer(PlyType) {
    mCursor.skipBlanksAndLines();
    return mCursor.integer();
  }
  void skip(PlyType, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
      mCursor.skipBlanksAndLines();
      if (mCursor.token().empty()) mCursor.fail("the file ends within its data; it looks truncated");
    }
  }
  /// Values that what is left can hold: a digit and a blank each.
  [[nodiscard]] std::uint64_t capacity(std::uint64_t) const { return (mCursor.remaining() + 1) / 2; }
  static std::uint64_t rowSize(const PlyElement& element) { return element.properties.size(); }
  [[noreturn]] void fail(const std::string& what) const { mCursor.fail(what); }
  bool atEnd() {
    mCursor.skipBlanksAndLines();
    return mCursor.atEnd();
  }

private:
  TextCursor mCursor;
};

/// Values of a binary body.
class BinaryInput {
public:
  BinaryInput(const MeshSource& source, const PlyHeader& header)
      : mSource(&source)
      , mAt(header.bodyOffset)
      , mSwap((header.encoding == PlyEncoding::BigEndian) == (std::endian::native == std::endian::little)) {}

  double number(PlyType type) {
    const double value = type == PlyType::Float32   ? static_cast<double>(take<float>())
                         : type == PlyType::Float64 ? take<double>()
                                                    : static_cast<double>(integer(type));
    if (!std::isfinite(value)) fail("a coordinate is not a finite number");
    return value;
  }
  std::int64_t integer(PlyType type) {
    switch (type) {
    case PlyType::Int8:
      return take<std::int8_t>();
    case PlyType::Uint8:
      return take<std::uint8_t>();
    case PlyType::Int16:
      return take<std::int16_t>();
    case PlyType::Uint16:
      return take<std::uint16_t>();
    case PlyType::Int32:
      return take<std::int32_t>();
    case PlyType::Uint32:
      return take<std::uint32_t>();
    default:
      fail("a whole number is expected"); // the header's check keeps floats away from here
    }
  }
  void skip(PlyType type, std::uint64_t count) {
    if (count > capacity(plySize(type))) fail("the file ends within its data; it looks truncated");
    mAt += count * plySize(type);
  }
  [[nodiscard]] std::uint64_t capacity(std::uint64_t size) const { return (mSource->content.size() - mAt) / size; }
  static std::uint64_t rowSize(const PlyElement& element) { return element.minimumRowBytes(); }
  [[noreturn]] void fail(const std::string& what) const { mSource->failAtByte(mAt, what); }
  bool atEnd() const { return mAt == mSource->content.size(); }

private:
  template <class T>
  T take() {
    if (mSource->content.size() - mAt < sizeof(T)) fail("the file ends within its data; it looks truncated");
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), mSource->content.data() + mAt, sizeof(T));
    if (mSwap) std::reverse(bytes.begin(), bytes.end());
    mAt += sizeof(T);
    return std::bit_cast<T>(bytes);
  }

  const MeshSource* mSource;
  std::size_t mAt;
  bool mSwap;
};

bool holdsTriangles(const PlyElement& element) { return element.name == "face" || element.name == "tristrips"; }
bool isIndexList(const PlyProperty& p) { return p.name == "vertex_indices" || p.name == "vertex_index"; }

template <class Input>
class BodyReader {
public:
  BodyReader(const MeshSource& source, const PlyHeader& header, const RunContext& ctx)
      : mSource(source), mHeader(header), mCtx(ctx), mInput(source, header), mBuilder(source, ctx) {}

  Mesh read();

private:
  void readVertices(const PlyElement& element);
  void readIndexLists(const PlyElement& element);
  void skipElement(const PlyElement& element);
  void skipProperty(const PlyProperty& property);
  void readList(const PlyProperty& property);
  std::uint64_t readCount(const PlyProperty& property);
  void addFace();
  void addStrip();
  void requireRows(const PlyElement& element);
  std::uint32_t checkedIndex(std::int64_t index);

  const MeshSource& mSource;
  const PlyHeader& mHeader;
  const RunContext& mCtx;
  Input mInput;
  MeshBuilder mBuilder;
  std::vector<std::int64_t> mList;
  std::vector<std::uint32_t> mCorners;
};

template <class Input>
Mesh BodyReader<Input>::read() {
  const auto& elements = mHeader.elements;
  const auto isVertex = [](const PlyElement& e) { return e.name == "vertex"; };
  const auto vertices = std::find_if(elements.begin(), elements.end(), isVertex);
  if (vertices == elements.end()) mSource.fail("the header has no element 'vertex', so there is no mesh in it");

  const Input body = mInput;
  for (auto e = elements.begin(); e != vertices; ++e) skipElement(*e);
  readVertices(*vertices);
  auto next = vertices + 1;
  if (std::any_of(elements.begin(), vertices, holdsTriangles)) { // they had to wait for the positions
    mInput = body;
    next = elements.begin();
  }
  for (; next != elements.end(); ++next)
    if (holdsTriangles(*next))
      readIndexLists(*next);
    else
      skipElement(*next);
  if (!mInput.atEnd()) mCtx.warn(mSource.name + ": data behind the last element of the header are ignored");
  return mBuilder.take();
}

/// Checks a count that the header claims against what is left of the file.
template <class Input>
void BodyReader<Input>::requireRows(const PlyElement& element) {
  const std::uint64_t row = Input::rowSize(element);
  if (row == 0 || element.count <= mInput.capacity(1) / row) return;
  mInput.fail("the header announces " + std::to_string(element.count) + " rows of '" + element.name +
              "', more than the rest of the file can hold; it is truncated or damaged");
}

template <class Input>
void BodyReader<Input>::readVertices(const PlyElement& element) {
  std::vector<int> axes; // of each property: 0, 1, 2, or -1 for others
  for (const PlyProperty& p : element.properties)
    axes.push_back(p.countType ? -1 : p.name == "x" ? 0 : p.name == "y" ? 1 : p.name == "z" ? 2 : -1);
  for (const int axis : {0, 1, 2})
    if (std::count(axes.begin(), axes.end(), axis) != 1)
      mSource.fail("element 'vertex' needs one property each of x, y and z");
  requireRows(element);
  mBuilder.reserve(element.count, 0);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    Vec3d p{};
    for (std::size_t k = 0; k < axes.size(); ++k)
      if (axes[k] >= 0)
        p[axes[k]] = mInput.number(element.properties[k].type);
      else
        skipProperty(element.properties[k]);
    mBuilder.addPosition(p);
  }
}

template <class Input>
void BodyReader<Input>::readIndexLists(const PlyElement& element) {
  const auto list = std::find_if(element.properties.begin(), element.properties.end(), isIndexList);
  if (element.count == 0) return;
  if (list == element.properties.end() || !list->countType || !isWhole(list->type))
    mSource.fail("element '" + element.name + "' needs a list of whole numbers named vertex_indices");
  requireRows(element);
  const bool strips = element.name == "tristrips";
  if (!strips) mBuilder.reserve(mBuilder.positionCount(), mBuilder.triangleCount() + element.count);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (auto p = element.properties.begin(); p != element.properties.end(); ++p)
      if (p == list)
        readList(*p);
      else
        skipProperty(*p);
    if (strips)
      addStrip();
    else
      addFace();
  }
}

template <class Input>
void BodyReader<Input>::skipElement(const PlyElement& element) {
  if (element.properties.empty()) return;
  requireRows(element);
  for (std::uint64_t i = 0; i < element.count; ++i)
    for (const PlyProperty& p : element.properties) skipProperty(p);
}

template <class Input>
void BodyReader<Input>::skipProperty(const PlyProperty& property) {
  mInput.skip(property.type, property.countType ? readCount(property) : 1);
}

template <class Input>
std::uint64_t BodyReader<Input>::readCount(const PlyProperty& property) {
  const std::int64_t count = mInput.integer(*property.countType);
  if (count < 0 || static_cast<std::uint64_t>(count) > mInput.capacity(plySize(property.type)))
    mInput.fail("a list '" + property.name + "' of " + std::to_string(count) +
                " items does not fit into the rest of the file; it is truncated or damaged");
  return static_cast<std::uint64_t>(count);
}

template <class Input>
void BodyReader<Input>::readList(const PlyProperty& property) {
  const std::uint64_t count = readCount(property);
  if (count > mList.capacity()) mCtx.requireMemory(mSource.content.size() + count * 2 * sizeof(mList[0]), mSource.name);
  mList.resize(count);
  for (std::int64_t& index : mList) index = mInput.integer(property.type);
}

template <class Input>
std::uint32_t BodyReader<Input>::checkedIndex(std::int64_t index) {
  if (index < 0 || index >= static_cast<std::int64_t>(mBuilder.positionCount()))
    mInput.fail("a face refers to vertex " + std::to_string(index) + "; the file has " +
                std::to_string(mBuilder.positionCount()) + " and counts from 0");
  return static_cast<std::uint32_t>(index);
}

template <class Input>
void BodyReader<Input>::addFace() {
  if (mList.size() < 3) mInput.fail("a face needs three corners or more, this one has " + std::to_string(mList.size()));
  mCorners.clear();
  for (const std::int64_t index : mList) mCorners.push_back(checkedIndex(index));
  if (!mBuilder.addPolygon(mCorners))
    mInput.fail("a face of " + std::to_string(mList.size()) +
                " corners that is not convex is too large; triangulate it on export");
}

/// Every corner from the third on makes a triangle with the two before it, every other one wound the other way. A
/// corner that repeats one of the two only stitches strips together: it makes no triangle, but counts for the winding.
template <class Input>
void BodyReader<Input>::addStrip() {
  std::size_t start = 0;
  for (std::size_t i = 0; i < mList.size(); ++i) {
    if (mList[i] == -1) {
      start = i + 1;
      continue;
    }
    const std::uint32_t c = checkedIndex(mList[i]);
    if (i < start + 2) continue;
    const auto a = static_cast<std::uint32_t>(mList[i - 2]), b = static_cast<std::uint32_t>(mList[i - 1]);
    if (a == b || b == c || c == a) continue;
    if ((i - start) % 2 == 0)
      mBuilder.addTriangle(a, b, c);
    else
      mBuilder.addTriangle(b, a, c);
  }
}

} // namespace

Mesh readPly(const MeshSource& source, const RunContext& ctx) {
  const PlyHeader header = readPlyHeader(source);
  if (header.elements.empty()) source.fail("the header announces no elements, so there is no mesh in it");
  if (header.encoding == PlyEncoding::Text) return BodyReader<TextInput>(source, header, ctx).read();
  return BodyReader<BinaryInput>(source, header, ctx).read();
}

} // namespace volcaustic
