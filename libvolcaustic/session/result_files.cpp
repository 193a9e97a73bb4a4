#include "session/result_files.h"

#include "core/atomic_file.h"
#include "core/byte_archive.h"
#include "core/hashed_file.h"
#include "transport/lit_receivers.h"
#include "volcaustic/error.h"
#include "volume/radiance_archive.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace volcaustic {

namespace {

constexpr std::string_view kMagic = "volcaustic result " VOLCAUSTIC_VERSION "\n";

struct Footer {
  std::uint64_t key, hash;
};

void writeBalanced(ByteWriter& out, const PhotonResult& r) {
  out(r.radiance.domain());
  writeBytes(out, r.radiance.bricks());
  out(static_cast<bool>(r.receivers));
  if (r.receivers) {
    const ReceivedLight& light = r.receivers.data().light;
    out(light.irradiance);
    out(light.caustic);
    out(light.direct);
  }
  out(r.balance);
  out(static_cast<std::uint64_t>(r.parts.size()));
  for (const PassPart& part : r.parts) {
    out(part.name);
    out(part.ms);
  }
  out(r.sumsBytes);
  out(r.light);
  out(static_cast<std::uint64_t>(r.lights.size()));
  for (const PhotonResult& light : r.lights) writeBalanced(out, light);
}

PhotonResult readBalanced(ByteReader& in, const std::vector<Receiver>& receivers, const RunContext& ctx) {
  PhotonResult r;
  const auto domain = in.get<Domain>();
  auto light = std::make_shared<RadianceBricks>(domain.dims);
  readBytes(in, *light, ctx);
  r.radiance = RadianceVolume(domain, std::move(light));
  if (in.get<bool>()) {
    ReceivedLight received;
    in(received.irradiance);
    in(received.caustic);
    in(received.direct);
    r.receivers = LitReceivers(std::make_shared<const LitReceiverData>(
        LitReceiverData{ReceiverSet(receivers, domain, ctx), std::move(received)}));
  }
  in(r.balance);
  const auto parts = in.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < parts; ++i) {
    PassPart part;
    in(part.name);
    in(part.ms);
    r.parts.push_back(std::move(part));
  }
  in(r.sumsBytes);
  in(r.light);
  const auto lights = in.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < lights; ++i) r.lights.push_back(readBalanced(in, receivers, ctx));
  return r;
}

} // namespace

std::filesystem::path ResultFolder::fileOf(const StageKey& key) const { return mFolder / (mStage + "." + key.hex()); }

bool ResultFolder::has(const StageKey& key) const {
  std::error_code ignored;
  return enabled() && std::filesystem::exists(fileOf(key), ignored);
}

template <class Read>
auto ResultFolder::load(const StageKey& key, const Read& read) const -> decltype(read(std::declval<ByteReader&>())) {
  try {
    std::error_code failed;
    const std::uintmax_t size = std::filesystem::file_size(fileOf(key), failed);
    if (failed || size < kMagic.size() + sizeof(Footer)) return nullptr;
    context().requireMemory(size, "reading a stored result");
    std::vector<char> bytes(size);
    std::ifstream file(fileOf(key), std::ios::binary);
    const std::size_t content = bytes.size() - sizeof(Footer);
    XxHash64 hash;
    constexpr std::size_t kPiece = 4 << 20;
    for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
      const std::size_t part = std::min(kPiece, bytes.size() - at);
      if (!file.read(bytes.data() + at, static_cast<std::streamsize>(part))) return nullptr;
      if (at < content) hash.add(bytes.data() + at, std::min(part, content - at));
      context().throwIfCancelled();
    }
    Footer footer;
    std::memcpy(&footer, bytes.data() + content, sizeof footer);
    if (std::string_view(bytes.data(), kMagic.size()) != kMagic || footer.key != key.digest() ||
        footer.hash != hash.digest())
      return nullptr;
    ByteReader in(bytes.data() + kMagic.size(), bytes.data() + content);
    return read(in);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::Cancelled) throw;
  } catch (const std::exception&) { // not what it says it is, or too much for the memory: as if it were not there
  }
  return nullptr;
}

template <class Write>
void ResultFolder::save(const StageKey& key, const Write& write) const {
  if (!enabled()) return;
  try {
    std::filesystem::create_directories(mFolder);
    AtomicFile target(fileOf(key));
    HashedFile file(target.path());
    ByteWriter out(file, context());
    out.raw(kMagic.data(), kMagic.size());
    write(out);
    bool good = file.pubsync() == 0;
    out(Footer{key.digest(), file.digest()});
    good = file.pubsync() == 0 && good && out.good();
    if (!good) throw Error(ErrorKind::File, fileOf(key).string() + ": cannot be written: " + std::strerror(errno));
    target.commit();
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::Cancelled) throw;
    warn(error);
  } catch (const std::exception& error) { // the result itself is there
    warn(error);
  }
}

void ResultFolder::warn(const std::exception& error) const {
  context().warn(std::string("cache: ") + error.what() + "; goes on without");
}

std::shared_ptr<const PhotonResult> PhotonFiles::read(const StageKey& key) const {
  return load(key, [this](ByteReader& in) {
    return std::make_shared<const PhotonResult>(readBalanced(in, mReceivers(), context()));
  });
}

void PhotonFiles::write(const StageKey& key, const PhotonResult& result) const {
  save(key, [&](ByteWriter& out) { writeBalanced(out, result); });
}

std::shared_ptr<const ViewResult> ViewFiles::read(const StageKey& key) const {
  return load(key, [](ByteReader& in) {
    ViewResult r;
    in(r.image.width);
    in(r.image.height);
    in(r.image.channels);
    in(r.image.planes);
    const auto metadata = in.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < metadata; ++i) {
      std::string name;
      in(name);
      in(r.image.metadata[name]);
    }
    in(r.steps);
    in(r.raysNotFinite);
    in(r.raysAtStepLimit);
    in(r.samples);
    in(r.passes);
    return std::make_shared<const ViewResult>(std::move(r));
  });
}

void ViewFiles::write(const StageKey& key, const ViewResult& r) const {
  save(key, [&](ByteWriter& out) {
    out(r.image.width);
    out(r.image.height);
    out(r.image.channels);
    out(r.image.planes);
    out(static_cast<std::uint64_t>(r.image.metadata.size()));
    for (const auto& [name, text] : r.image.metadata) {
      out(name);
      out(text);
    }
    out(r.steps);
    out(r.raysNotFinite);
    out(r.raysAtStepLimit);
    out(r.samples);
    out(r.passes);
  });
}

} // namespace volcaustic
