// Reading OBJ files, and telling formats apart.
#include "unit/mesh_support.h"

namespace volcaustic::test {
namespace {

TEST(MeshReadObj, QuadsMakeAClosedCube) { expectClosed(readText("a.obj", kCubeObj), 12, 1); }

TEST(MeshReadObj, EverySpellingOfAFaceMeansTheSame) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
  for (const char* face :
       {"f 1 2 3", "f 1/1 2/1 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/1/1 3/1/1", "f -3 -2 -1", "f -3/-1/-1 2/1 -1//1",
        "f 1// 2/ 3//", "f\t1  2 3 # a face", "f 1 \\\n 2 \\\r\n3", "  f 1 2 3  "}) {
    const Mesh mesh = readText("a.obj", vertices + face);
    ASSERT_EQ(mesh.triangles.size(), 1u) << face;
    EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2})) << face;
  }
}

TEST(MeshReadObj, NumbersInEveryForm) {
  const Mesh mesh = readText("a.obj", "v +1 -2. .5\nv 1e2 2.E-1 -0\nv 0x1.8p+1 -0X.8 +1e-300\nf 1 2 3\n");
  EXPECT_EQ(mesh.positions[0], (Vec3d{1, -2, 0.5}));
  EXPECT_EQ(mesh.positions[1], (Vec3d{100, 0.2, 0}));
  EXPECT_EQ(mesh.positions[2], (Vec3d{3, -0.5, 1e-300}));
}

TEST(MeshReadObj, LineEndsOfEverySystem) {
  for (const std::string newline : {"\n", "\r\n", "\r"}) {
    std::string text;
    for (const char c : kCubeObj) text += c == '\n' ? newline : std::string(1, c);
    expectClosed(readText("a.obj", text), 12, 1);
    EXPECT_EQ(complaintAbout("a.obj", text + "f 1 2"), "a.obj:15: a face needs three corners or more, this one has 2");
  }
  expectClosed(readText("a.obj", "\xEF\xBB\xBF" + kCubeObj), 12, 1);
}

TEST(MeshReadObj, WeightsColoursAndForeignLinesAreSkipped) {
  const Mesh mesh = readText("a.obj", "mtllib a b.mtl\no f 1 2 9\ng f\nv 0 0 0 0.5\nv 1 0 0 nan nan nan\nvp 1\nl 1 2\n"
                                      "v 0 1 0\ns off\nf 1 2 3\np 7\ncurv2 9 9 \\\n9 9\n");
  EXPECT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.triangles.size(), 1u);
}

TEST(MeshReadObj, FacesMayComeBeforeTheirVertices) {
  const std::size_t faces = kCubeObj.find('f');
  expectClosed(readText("a.obj", kCubeObj.substr(faces) + kCubeObj.substr(0, faces)), 12, 1);
}

// Large files are read in pieces at once: numbers, names and line numbers go on across their borders.
TEST(MeshReadObj, PiecesOfALargeFileFit) {
  constexpr std::uint32_t kFaces = 30'000;
  for (const std::string newline : {"\n", "\r\n", " \\\n 0.125\n"}) {
    std::string text;
    for (std::uint32_t i = 0; i < kFaces; ++i) {
      if (i % 5'000 == 0) text += "usemtl m" + std::to_string(i % 10'000) + "\n";
      for (int v = 0; v < 3; ++v) text += "v " + std::to_string(i) + " " + std::to_string(v) + " 0.5" + newline;
      text += i % 2 ? "f -3 -2 -1\n" : "f " + std::to_string(3 * i + 1) + " -2 -1\n";
    }
    const Mesh mesh = readText("a.obj", text);
    ASSERT_EQ(mesh.triangles.size(), kFaces);
    EXPECT_EQ(mesh.groupNames, (std::vector<std::string>{"m0", "m5000"}));
    for (std::uint32_t i = 0; i < kFaces; ++i) {
      ASSERT_EQ(mesh.triangles[i], (std::array{3 * i, 3 * i + 1, 3 * i + 2}));
      ASSERT_EQ(mesh.positions[3 * i + 1], (Vec3d{double(i), 1, .5}));
      ASSERT_EQ(mesh.triangleGroup[i], i / 5'000 % 2);
    }
    const auto line = std::to_string(std::count(text.begin(), text.end(), '\n') + 1);
    for (const std::string end : {"v 1 2 x\n", "f 1 2\n"})
      EXPECT_TRUE(complaintAbout("a.obj", text + end + "f 1 2 3\n" + text).starts_with("a.obj:" + line + ": ")) << end;
  }
}

TEST(MeshReadObj, MaterialsBecomeGroups) {
  const Mesh mesh = readText("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nusemtl red glass \nf 1 2 3 4\n"
                                      "usemtl blue\nf 1 2 3\nusemtl red glass\nf 1 2 3\n");
  EXPECT_EQ(mesh.groupNames, (std::vector<std::string>{"", "red glass", "blue"}));
  EXPECT_EQ(mesh.triangleGroup, (std::vector<std::uint32_t>{0, 1, 1, 2, 1}));
  EXPECT_TRUE(readText("a.obj", kCubeObj).triangleGroup.empty());
}

TEST(MeshReadObj, GroupsOrObjectsServeWhereThereIsNoMaterial) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 1 1 0\n", f = "f 1 2 3\n";
  const auto groups = [&](const std::string& text) { return readText("a.obj", v + text).groupNames; };
  using Names = std::vector<std::string>;
  EXPECT_EQ(groups("o left\n" + f + "o right\n" + f), (Names{"left", "right"}));
  EXPECT_EQ(groups("o body\ng left part\n" + f + "g right\n" + f), (Names{"left part", "right"})) << "g wins over o";
  EXPECT_EQ(groups("o body\ng a\nusemtl red\n" + f + "g b\n" + f), (Names{"red"})) << "usemtl wins over both";
  EXPECT_EQ(groups("g default\ng a\n" + f + "g b\ng a\n" + f), (Names{"a"})) << "a group without faces is none";
  EXPECT_EQ(groups(f + "G late\n" + f), (Names{"", "late"}));
  const Mesh mesh = readText("a.obj", v + "g a\n" + f + "g b\n" + f + f + "g a\n" + f);
  EXPECT_EQ(mesh.triangleGroup, (std::vector<std::uint32_t>{0, 1, 1, 0}));
}

TEST(MeshReadObj, ErrorsNameTheLine) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::pair<std::string, std::string> cases[] = {
      {"f 1 2 4\n", "a.obj:4: face corner '4' refers to no vertex"},
      {"f 0 1 2\n", "a.obj:4: face corner '0' refers to no vertex"},
      {"f -4 1 2\n", "a.obj:4: face corner '-4' refers to no vertex"},
      {"f 1 2 99999999999999999999\n", "a.obj:4: face corner '99999999999999999999' is malformed"},
      {"f 1 2 3.5\n", "a.obj:4: face corner '3.5' is malformed"},
      {"f 1/1/1/1 2 3\n", "a.obj:4: face corner '1/1/1/1' is malformed"},
      {"f 1,2,3\n", "a.obj:4: face corner '1,2,3' is malformed"},
      {"\n\nf\n", "a.obj:6: a face needs three corners or more, this one has 0"},
      {"f 1 2 \\\n\nf 1 2 3", "a.obj:4: a face needs three corners or more, this one has 2"},
      {"v 1 2\n", "a.obj:4: the line ends where a number is expected"},
      {"v 1 2 x\n", "a.obj:4: 'x' is not a number"},
      {"v 1 2 3.1+e2\n", "a.obj:4: '3.1+e2' is not a number"},
      {"v 1 2 1,5\n", "a.obj:4: '1,5' is not a number"},
      {"v 1 2 +-3\n", "a.obj:4: '+-3' is not a number"},
      {"v 1 nan 3\n", "a.obj:4: 'nan' is not a finite number"},
      {"v 1 -inf 3\n", "a.obj:4: '-inf' is not a finite number"},
      {"v 1 1e999 3\n", "a.obj:4: '1e999' is beyond the range of a double"},
      {"v 1 2 \x01\x80\n", "a.obj:4: '?"
                           "?' is not a number"}};
  for (const auto& [text, expected] : cases) {
    const std::string what = complaintAbout("a.obj", v + text);
    EXPECT_TRUE(what.starts_with(expected)) << what;
  }
}

TEST(MeshReadObj, NoTriangleIsAnError) {
  for (const char* text : {"v 0 0 0\n", "v 0 0 0\nv 1 0 0\nl 1 2\n", "hello world\n", "\n", " ", "# nothing"})
    EXPECT_NE(complaintAbout("a.obj", text).find("holds no triangle"), std::string::npos) << text;
}

TEST(MeshReadSniff, ContentGoesBeforeExtension) {
  const std::string off = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  for (const char* name : {"a.off", "a.obj", "a.ply", "a.stl", "a", "a.mesh"})
    expectClosed(readText(name, off), 4, 1.0 / 6);
  expectClosed(readText("a.txt", kCubeObj), 12, 1);
  expectClosed(readText("a.off", off.substr(4)), 4, 1.0 / 6); // the keyword may be missing
}

TEST(MeshReadSniff, WhatIsNoMeshSaysSo) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "is empty"},
      {"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "Git LFS pointer"},
      {"\n<!DOCTYPE html><html>", "HTML"},
      {std::string("\xFF\xFEv\0 \0", 6), "UTF-16"},
      {std::string("\x7f"
                   "ELF\0\0\0\0",
                   8),
       "is no mesh that can be read"}};
  for (const auto& [text, expected] : cases)
    EXPECT_NE(complaintAbout("a.obj", text).find(expected), std::string::npos) << expected;
  EXPECT_NE(complaintAbout("a.ply", "plx\n").find("no PLY file"), std::string::npos);
}

TEST(MeshReadSniff, FilesThatCannotBeOpened) {
  const TemporaryFolder folder;
  EXPECT_NE(complaint(folder / "none.obj", ErrorKind::File).find("No such file"), std::string::npos);
  std::filesystem::create_directory(folder / "folder.obj");
  EXPECT_NE(complaint(folder / "folder.obj", ErrorKind::File).find("is a folder"), std::string::npos);
}

TEST(MeshReadSniff, MemoryLimitAndCancellationAreObeyed) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 100000; ++i) text += "f 1 2 3\n";
  RunContext ctx;
  ctx.memoryLimit = 1 << 20;
  EXPECT_NE(complaintAbout("a.obj", text, ctx).find("memory limit"), std::string::npos);
  const std::atomic<bool> cancel = true;
  RunContext cancelled;
  cancelled.cancel = &cancel;
  const TemporaryFolder folder;
  writeFile(folder / "a.obj", text);
  try {
    (void)readMesh(folder / "a.obj", cancelled);
    FAIL() << "not cancelled";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Cancelled);
  }
}

} // namespace
} // namespace volcaustic::test
