// Damaged files: whatever bytes come, reading ends in a mesh that is valid or in an Error, within bounded memory.
#include "unit/mesh_support.h"

#include <bit>
#include <random>

namespace volcaustic::test {
namespace {

struct Seed {
  std::string name, content;
};

/// A small file of every format and form, by our own writers and, where they write no such form, by hand.
std::vector<Seed> seeds() {
  const TemporaryFolder folder;
  Mesh mesh = readText("a.obj", kCubeObj);
  mesh.groupNames = {"one", "two"};
  mesh.triangleGroup.assign(mesh.triangles.size(), 0);
  mesh.triangleGroup.back() = 1;
  std::vector<Seed> result;
  for (const bool binary : {false, true})
    for (const char* name : {"a.obj", "a.ply", "a.stl", "a.off"}) {
      writeMesh(folder / name, mesh, {binary});
      result.push_back({name, readFile(folder / name)});
    }
  result.push_back(
      {"a.obj", kCubeObj + "usemtl x\nf -8/1/1 -7//2 \\\n -6/3 # c\nf 1 3 2 4 8 5 6 7\nv +1e2 0x1.8p1 .5 1 1 1\n"});
  std::string strips = "ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty double x\nproperty float y\n"
                       "property short z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  for (int i = 0; i < 4; ++i)
    strips += bytes(i * 0.5, true) + bytes(float(i * i), true) + bytes(std::int16_t(i % 2), true);
  strips += bytes(9, true);
  for (const int i : {0, 1, 2, 3, -1, 1, 0, 2, 3}) strips += bytes(i, true);
  result.push_back({"a.ply", strips});
  std::string off = "OFF BINARY\n" + bytes(4) + bytes(2) + bytes(0);
  for (int i = 0; i < 12; ++i) off += bytes(float(i * i % 7));
  for (const int i : {3, 0, 1, 2, 4, 0, 1, 2, 3}) off += bytes(i);
  result.push_back({"a.off", off});
  return result;
}

std::string mutated(std::string text, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return n ? random() % n : 0; };
  static const std::string kWords[] = {"99999999",         "-1",   "nan", "1e999", "\n", " ", "0",
                                       "\xff\xff\xff\xff", "\\\n", "/",   "#"};
  for (std::size_t changes = 1 + below(4); changes-- > 0;) {
    const std::size_t at = below(text.size());
    switch (below(6)) {
    case 0:
      text.resize(at);
      break;
    case 1:
      text.erase(at, 1 + below(8));
      break;
    case 2:
      text.insert(at, kWords[below(std::size(kWords))]);
      break;
    case 3:
      text.insert(at, text.substr(below(text.size()), 1 + below(40)));
      break;
    default:
      if (!text.empty()) text[at] = static_cast<char>(random());
    }
  }
  return text;
}

TEST(MeshFuzz, DamageEndsInAValidMeshOrAnError) {
  constexpr int kMutations = 1500;
  const TemporaryFolder folder;
  RunContext ctx;
  ctx.memoryLimit = 16 << 20;
  std::mt19937 random(20080311);
  int read = 0, refused = 0;
  for (const Seed& seed : seeds()) {
    ASSERT_EQ(complaintAbout(seed.name, seed.content), "");
    for (int i = 0; i < kMutations; ++i) {
      const std::string content = mutated(seed.content, random);
      writeFile(folder / seed.name, content);
      try {
        const Mesh mesh = readMesh(folder / seed.name, ctx);
        ASSERT_LE(mesh.triangles.size(), content.size());
        (void)checkMesh(mesh, ctx); // throws for a mesh that is not valid
        ++read;
      } catch (const Error& error) {
        const std::string what = error.what();
        ASSERT_TRUE(what.starts_with((folder / seed.name).string() + ":")) << what;
        ASSERT_EQ(what.find('\n'), what.npos) << what;
        ++refused;
      }
    }
  }
  EXPECT_GT(read, 1000);
  EXPECT_GT(refused, 1000);
}

} // namespace
} // namespace volcaustic::test
