// A .gltf or .glb file: its JSON, parsed, and its buffers, read when they are asked for.
#pragma once

#include "scene/gltf_value.h"
#include "volcaustic/run_context.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace volcaustic {

/// Not to be used by two threads at once.
class GltfFile {
public:
  /// Reads the JSON and looks at every buffer's length, without reading it. The context must outlive the file.
  /// \throws Error(File) when it cannot be opened, Error(Input) for anything else that is wrong with the container, for
  /// a required extension that is not read here, and for buffers that are missing or short.
  GltfFile(const std::filesystem::path& path, const RunContext& ctx);
  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;

  [[nodiscard]] const RunContext& context() const { return mContext; }
  [[nodiscard]] const std::string& name() const { return mName; }
  /// The file itself and those beside it that hold its buffers.
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
  /// Without its folder.
  [[nodiscard]] std::string fileName() const { return mPath.filename().string(); }
  [[nodiscard]] GltfValue root() const { return {mJson, mName}; }
  /// How many there are in a list of the document: "nodes", "meshes", ...
  [[nodiscard]] std::size_t count(const char* list) const;
  [[nodiscard]] GltfValue item(const char* list, std::size_t index) const;
  /// The element of a list that `reference` holds the number of.
  [[nodiscard]] GltfValue resolve(const GltfValue& reference, const char* list) const;
  [[nodiscard]] std::size_t indexOf(const GltfValue& reference, const char* list) const;

  /// Counts numbers that are about to be read at `place`. Many readers may share one accessor, so that a small file
  /// asks for any amount of work. \throws Error(Input) beyond what an honest file needs.
  void countNumbers(std::uint64_t numbers, const GltfValue& place);

  /// Bytes of buffer `index` as its byteLength says, checked against the file that holds them.
  [[nodiscard]] std::uint64_t bufferSize(std::size_t index) const { return mBuffers[index].size; }
  /// All of them. Valid until the file goes.
  std::string_view bufferBytes(std::size_t index);

private:
  struct Buffer {
    std::uint64_t size = 0;
    std::filesystem::path path; ///< that holds the bytes, from `offset` on; empty for base64
    std::uint64_t offset = 0;
    std::string_view base64;
    std::string bytes;
    bool isRead = false;
  };

  void readContainer();
  void readBinary(std::uint64_t fileSize);
  void checkVersion() const;
  void checkExtensions() const;
  [[nodiscard]] Buffer placeBuffer(const GltfValue& buffer, bool first) const;
  [[nodiscard]] Buffer placeUri(const GltfValue& uri, std::uint64_t& available) const;

  std::filesystem::path mPath;
  std::string mName;
  const RunContext& mContext;
  Json mJson;
  std::uint64_t mBinaryOffset = 0, mBinarySize = 0; ///< of the BIN chunk; 0 without one
  std::vector<Buffer> mBuffers;
  std::uint64_t mNumbersRead = 0;
};

} // namespace volcaustic
