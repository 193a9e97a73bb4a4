// Numbers of a glTF file: an accessor, dense or sparse, over a part of a buffer.
#pragma once

#include "scene/gltf_file.h"

#include <cstdint>
#include <vector>

namespace volcaustic {

class GltfAccessor {
public:
  /// Checks the accessor that `reference` holds the number of against the views and buffers it lies in; reads no bytes.
  /// `type` is what it must be ("SCALAR", "VEC3", "VEC4").
  /// \throws Error(Input) at the pointer of what does not fit.
  GltfAccessor(GltfFile& file, const GltfValue& reference, const char* type);

  [[nodiscard]] const GltfValue& place() const { return mPlace; }
  [[nodiscard]] std::size_t count() const { return mCount; }

  /// Element after element; integers that say so are normalised to [0, 1] or [-1, 1].
  /// \throws Error(Input) for a number that is not finite.
  [[nodiscard]] std::vector<double> numbers() const;
  /// Whole numbers from 0 up. \throws Error(Input) for accessors of other numbers.
  [[nodiscard]] std::vector<std::uint32_t> indices() const;

private:
  /// Equally spaced elements inside a buffer.
  struct Run {
    std::size_t buffer = 0;
    std::uint64_t begin = 0, stride = 0;
  };
  struct Component {
    int type;
    std::uint64_t size;
  };

  [[nodiscard]] static Component component(const GltfValue& type);
  [[nodiscard]] Run run(const GltfValue& owner, std::uint64_t elementSize, std::uint64_t count) const;
  void checkSparse(const GltfValue& sparse);
  [[nodiscard]] double normalised(double value) const;
  template <class Store>
  void forEachNumber(const Store& store) const;

  GltfFile& mFile;
  GltfValue mPlace;
  std::size_t mCount = 0, mComponents = 1;
  Component mComponent{};
  bool mNormalised = false, mIsDense = false, mIsSparse = false;
  Run mRun, mSparseRun;
  std::vector<std::uint64_t> mSparseAt; ///< elements that the sparse run replaces, ascending
};

} // namespace volcaustic
