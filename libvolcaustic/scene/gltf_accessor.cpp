#include "scene/gltf_accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace volcaustic {

namespace {

constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
              kFloat = 5126;

/// An accessor without a view is zeros that no byte of the file stands for: more than these are no honest file's.
constexpr std::uint64_t kMostZeros = std::uint64_t{1} << 24;

template <class T>
double loaded(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double load(int type, const char* bytes) {
  switch (type) {
  case kByte:
    return loaded<std::int8_t>(bytes);
  case kUnsignedByte:
    return loaded<std::uint8_t>(bytes);
  case kShort:
    return loaded<std::int16_t>(bytes);
  case kUnsignedShort:
    return loaded<std::uint16_t>(bytes);
  case kUnsignedInt:
    return loaded<std::uint32_t>(bytes);
  default:
    return loaded<float>(bytes);
  }
}

std::size_t componentsOf(const GltfValue& type, const char* wanted) {
  if (type.text() != wanted) type.fail("must be \"" + std::string(wanted) + "\" here, not " + excerpt(type.text()));
  return type.text() == "SCALAR" ? 1 : static_cast<std::size_t>(type.text().back() - '0');
}

bool isIndexType(int type) { return type == kUnsignedByte || type == kUnsignedShort || type == kUnsignedInt; }

} // namespace

GltfAccessor::GltfAccessor(GltfFile& file, const GltfValue& reference, const char* type)
    : mFile(file), mPlace(file.resolve(reference, "accessors")) {
  mComponents = componentsOf(mPlace.at("type"), type);
  mComponent = component(mPlace.at("componentType"));
  const std::uint64_t elementSize = mComponents * mComponent.size;
  mCount = mPlace.at("count").whole();
  if (mCount == 0) mPlace.at("count").fail("0 elements; export it again");
  if (const auto flag = mPlace.find("normalized")) mNormalised = flag->flag() && mComponent.type != kFloat;
  mIsDense = mPlace.find("bufferView").has_value();
  if (mIsDense)
    mRun = run(mPlace, elementSize, mCount);
  else if (mCount * mComponents > kMostZeros)
    mPlace.at("count").fail(std::to_string(mCount) + " elements without a bufferView; export it again");
  if (const auto sparse = mPlace.find("sparse")) checkSparse(*sparse);
}

GltfAccessor::Component GltfAccessor::component(const GltfValue& type) {
  const std::uint64_t code = type.whole();
  switch (code) {
  case kByte:
  case kUnsignedByte:
    return {static_cast<int>(code), 1};
  case kShort:
  case kUnsignedShort:
    return {static_cast<int>(code), 2};
  case kUnsignedInt:
  case kFloat:
    return {static_cast<int>(code), 4};
  default:
    type.fail(std::to_string(code) + " is no component type of glTF 2.0; export it again");
  }
}

GltfAccessor::Run GltfAccessor::run(const GltfValue& owner, std::uint64_t elementSize, std::uint64_t count) const {
  const GltfValue view = mFile.resolve(owner.at("bufferView"), "bufferViews");
  const std::size_t buffer = mFile.indexOf(view.at("buffer"), "buffers");
  const auto offsetOf = [](const GltfValue& value) {
    const auto offset = value.find("byteOffset");
    return offset ? offset->whole() : 0;
  };
  const std::uint64_t viewBegin = offsetOf(view), viewSize = view.at("byteLength").whole(), begin = offsetOf(owner);
  if (viewBegin > mFile.bufferSize(buffer) || viewSize > mFile.bufferSize(buffer) - viewBegin)
    view.fail("reaches beyond the " + std::to_string(mFile.bufferSize(buffer)) +
              " bytes of its buffer; export it again");
  const auto givenStride = view.find("byteStride");
  const std::uint64_t stride = givenStride ? givenStride->whole() : elementSize;
  if (stride < elementSize || stride > 252)
    givenStride->fail(std::to_string(stride) + " is out of range; give from " + std::to_string(elementSize) +
                      " to 252");
  // count and stride are below 2^53 and 2^8: no overflow.
  if (begin > viewSize || elementSize > viewSize - begin || (count - 1) * stride > viewSize - begin - elementSize)
    owner.fail("its " + std::to_string(count) + " elements reach beyond the " + std::to_string(viewSize) +
               " bytes of " + view.pointer() + "; export it again");
  return {buffer, viewBegin + begin, stride};
}

void GltfAccessor::checkSparse(const GltfValue& sparse) {
  const std::uint64_t count = sparse.at("count").whole();
  if (count == 0 || count > mCount)
    sparse.at("count").fail(std::to_string(count) + " of " + std::to_string(mCount) + " elements; export it again");
  const GltfValue indices = sparse.at("indices"), type = indices.at("componentType");
  const Component index = component(type);
  if (!isIndexType(index.type)) type.fail("must be an unsigned integer type; export it again");
  const Run at = run(indices, index.size, count);
  mSparseRun = run(sparse.at("values"), mComponents * mComponent.size, count);
  mFile.countNumbers(count, sparse);
  const std::string_view bytes = mFile.bufferBytes(at.buffer);
  mSparseAt.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto element = static_cast<std::uint64_t>(load(index.type, bytes.data() + at.begin + i * at.stride));
    if (element >= mCount || (i > 0 && element <= mSparseAt.back()))
      indices.fail("number " + std::to_string(i) + " is " + std::to_string(element) +
                   "; they must ascend and stay below " + std::to_string(mCount));
    mSparseAt.push_back(element);
  }
  mIsSparse = true;
}

double GltfAccessor::normalised(double value) const {
  switch (mComponent.type) {
  case kByte:
    return std::max(value / 127, -1.0);
  case kUnsignedByte:
    return value / 255;
  case kShort:
    return std::max(value / 32767, -1.0);
  case kUnsignedShort:
    return value / 65535;
  default:
    return value / std::numeric_limits<std::uint32_t>::max();
  }
}

/// Calls store(position, number) for every number, and again for those that are replaced.
template <class Store>
void GltfAccessor::forEachNumber(const Store& store) const {
  const auto readElement = [&](const Run& run, std::string_view bytes, std::uint64_t from, std::uint64_t to) {
    const char* element = bytes.data() + run.begin + from * run.stride;
    for (std::size_t c = 0; c < mComponents; ++c)
      store(to * mComponents + c, load(mComponent.type, element + c * mComponent.size));
  };
  if (mIsDense) {
    const std::string_view bytes = mFile.bufferBytes(mRun.buffer);
    for (std::uint64_t i = 0; i < mCount; ++i) readElement(mRun, bytes, i, i);
  }
  if (mIsSparse) {
    const std::string_view bytes = mFile.bufferBytes(mSparseRun.buffer);
    for (std::uint64_t i = 0; i < mSparseAt.size(); ++i) readElement(mSparseRun, bytes, i, mSparseAt[i]);
  }
}

std::vector<double> GltfAccessor::numbers() const {
  mFile.countNumbers(mCount * mComponents, mPlace);
  mFile.context().requireMemory(mCount * mComponents * sizeof(double), mFile.name());
  std::vector<double> values(mCount * mComponents);
  forEachNumber([&](std::uint64_t at, double value) {
    if (!std::isfinite(value))
      mPlace.fail("element " + std::to_string(at / mComponents) + " is not finite; export it again");
    values[at] = mNormalised ? normalised(value) : value;
  });
  return values;
}

std::vector<std::uint32_t> GltfAccessor::indices() const {
  if (!isIndexType(mComponent.type) || mNormalised)
    mPlace.at("componentType").fail("indices must be of an unsigned integer type; export it again");
  mFile.countNumbers(mCount, mPlace);
  mFile.context().requireMemory(mCount * sizeof(std::uint32_t), mFile.name());
  std::vector<std::uint32_t> values(mCount);
  forEachNumber([&](std::uint64_t at, double value) { values[at] = static_cast<std::uint32_t>(value); });
  return values;
}

} // namespace volcaustic
