// What a file holds, from its first bytes and its extension.
#pragma once

#include <string>

namespace volcaustic::cli {

enum class FileKind {
  Volume,
  Image,
  Mesh,
  Scene ///< or a shape: .json too
};

/// \throws Error(File) when the folder that a file is to be written to does not exist.
void checkFolderOf(const std::string& path);
/// \throws Error(File) when it cannot be read, Error(Input) when it is none of them.
FileKind fileKind(const std::string& path);
/// Before the work that makes it: whether a file of this kind can be written under this name. "-", standard output, is
/// for volumes. \throws Error(Usage) for the extension of another kind or of none, Error(File) when there is no such
/// folder.
void checkOutput(const std::string& path, FileKind kind);

} // namespace volcaustic::cli
