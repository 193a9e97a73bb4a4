#include "session/result_files.h"

#include "core/atomic_file.h"
#include "core/byte_archive.h"
#include "core/xxhash64.h"
#include "transport/lit_receivers.h"
#include "volcaustic/error.h"
#include "volume/radiance_archive.h"

#include <cstdint>
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

std::uint64_t hashOf(const char* data, std::size_t size) {
  XxHash64 hash;
  hash.add(data, size);
  return hash.digest();
}

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

std::optional<std::vector<char>> ResultFolder::load(const StageKey& key) const {
  if (!has(key)) return std::nullopt;
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(fileOf(key), failed);
  if (failed || size < kMagic.size() + sizeof(Footer) || size > context().effectiveMemoryLimit()) return std::nullopt;
  std::vector<char> bytes(size);
  std::ifstream file(fileOf(key), std::ios::binary);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) return std::nullopt;
  Footer footer;
  const std::size_t content = bytes.size() - sizeof footer;
  std::memcpy(&footer, bytes.data() + content, sizeof footer);
  if (std::string_view(bytes.data(), kMagic.size()) != kMagic || footer.key != key.digest() ||
      footer.hash != hashOf(bytes.data(), content))
    return std::nullopt;
  bytes.resize(content);
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(kMagic.size()));
  return bytes;
}

void ResultFolder::save(const StageKey& key, const std::vector<char>& bytes) const {
  try {
    std::filesystem::create_directories(mFolder);
    AtomicFile target(fileOf(key));
    std::ofstream file(target.path(), std::ios::binary);
    XxHash64 hash;
    hash.add(kMagic.data(), kMagic.size());
    hash.add(bytes.data(), bytes.size());
    const Footer footer{key.digest(), hash.digest()};
    file.write(kMagic.data(), static_cast<std::streamsize>(kMagic.size()));
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.write(reinterpret_cast<const char*>(&footer), sizeof footer);
    file.close();
    if (!file) throw Error(ErrorKind::File, fileOf(key).string() + ": cannot be written");
    target.commit();
  } catch (const std::exception& error) { // the result itself is there
    context().warn(std::string("cache: ") + error.what() + "; goes on without");
  }
}

std::shared_ptr<const PhotonResult> PhotonFiles::read(const StageKey& key) const {
  const auto bytes = load(key);
  if (!bytes) return nullptr;
  try {
    ByteReader in(bytes->data(), bytes->data() + bytes->size());
    return std::make_shared<const PhotonResult>(readBalanced(in, mReceivers(), context()));
  } catch (const std::out_of_range&) {
    return nullptr;
  }
}

void PhotonFiles::write(const StageKey& key, const PhotonResult& result) const {
  if (!enabled()) return;
  ByteWriter out;
  writeBalanced(out, result);
  save(key, out.bytes());
}

std::shared_ptr<const ViewResult> ViewFiles::read(const StageKey& key) const {
  const auto bytes = load(key);
  if (!bytes) return nullptr;
  try {
    ByteReader in(bytes->data(), bytes->data() + bytes->size());
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
  } catch (const std::out_of_range&) {
    return nullptr;
  }
}

void ViewFiles::write(const StageKey& key, const ViewResult& r) const {
  if (!enabled()) return;
  ByteWriter out;
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
  save(key, out.bytes());
}

} // namespace volcaustic
