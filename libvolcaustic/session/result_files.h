// Results of stages in a folder, by their keys (SessionOptions::cache).
#pragma once

#include "session/stage_key.h"
#include "volcaustic/photons.h"
#include "volcaustic/view.h"

#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace volcaustic {

class ByteReader;

/// One file for each key. A file that is damaged, or of another version, is as if it were not there; one that cannot be
/// written is warned of, once for each result.
class ResultFolder {
public:
  /// \param folder empty for none; made when first written to
  ResultFolder(std::filesystem::path folder, std::string stage, const RunContext& ctx)
      : mFolder(std::move(folder)), mStage(std::move(stage)), mContext(ctx) {}

  [[nodiscard]] bool has(const StageKey& key) const;

protected:
  [[nodiscard]] bool enabled() const { return !mFolder.empty(); }
  /// read(ByteReader&) of the key's file; null where there is none that is whole. \throws Error(Cancelled)
  template <class Read>
  auto load(const StageKey& key, const Read& read) const -> decltype(read(std::declval<ByteReader&>()));
  /// Makes the key's file by write(ByteWriter&). \throws Error(Cancelled)
  template <class Write>
  void save(const StageKey& key, const Write& write) const;
  [[nodiscard]] const RunContext& context() const { return mContext; }

private:
  void warn(const std::exception& error) const;
  [[nodiscard]] std::filesystem::path fileOf(const StageKey& key) const;

  std::filesystem::path mFolder;
  std::string mStage;
  const RunContext& mContext;
};

class PhotonFiles : public ResultFolder {
public:
  /// \param receivers of the scene, whose light the files hold without their surfaces
  PhotonFiles(std::filesystem::path folder, const RunContext& ctx, std::function<std::vector<Receiver>()> receivers)
      : ResultFolder(std::move(folder), "photons", ctx), mReceivers(std::move(receivers)) {}
  [[nodiscard]] std::shared_ptr<const PhotonResult> read(const StageKey& key) const;
  void write(const StageKey& key, const PhotonResult& result) const;

private:
  std::function<std::vector<Receiver>()> mReceivers;
};

class ViewFiles : public ResultFolder {
public:
  ViewFiles(std::filesystem::path folder, const RunContext& ctx) : ResultFolder(std::move(folder), "view", ctx) {}
  [[nodiscard]] std::shared_ptr<const ViewResult> read(const StageKey& key) const;
  void write(const StageKey& key, const ViewResult& result) const;
};

} // namespace volcaustic
