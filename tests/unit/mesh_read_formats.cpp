// Reading PLY, STL and OFF files, text and binary.
#include "unit/mesh_support.h"

#include <bit>
#include <limits>

namespace volcaustic::test {
namespace {

const std::vector<std::array<float, 3>> kCorners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<std::array<int, 3>> kFaces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

std::string plyHeader(const std::string& format, const std::string& newline = "\n") {
  std::string header;
  for (const std::string line :
       {"ply", format.c_str(), "comment a # comment", "element vertex 4", "property float x", "property float y",
        "property float z", "element face 4", "property list uchar int vertex_indices", "end_header"})
    header += line + newline;
  return header;
}

std::string plyBinary(bool bigEndian, const std::string& newline = "\n") {
  std::string text = plyHeader(bigEndian ? "format binary_big_endian 1.0" : "format binary_little_endian 1.0", newline);
  for (const auto& p : kCorners)
    for (const float x : p) text += bytes(x, bigEndian);
  for (const auto& f : kFaces) {
    text += '\3';
    for (const int i : f) text += bytes(i, bigEndian);
  }
  return text;
}

const std::string kPlyBody = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::string stlBinary(const std::string& start = "") {
  std::string text = start + std::string(80 - start.size(), ' ') + bytes(std::uint32_t(kFaces.size()));
  for (const auto& f : kFaces) {
    text += std::string(12, '\0');
    for (const int i : f)
      for (const float x : kCorners[i]) text += bytes(x);
    text += std::string(2, '\0');
  }
  return text;
}

std::string stlText(const std::string& name, double shift) {
  std::string text = "solid " + name + "\n";
  for (const auto& f : kFaces) {
    text += "  facet normal nan 0 0\n    outer loop\n";
    for (const int i : f)
      text += "      vertex " + std::to_string(kCorners[i][0] + shift) + " " + std::to_string(kCorners[i][1]) + " " +
              std::to_string(kCorners[i][2]) + "\n";
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid " + name + "\n";
}

std::string offBinary(bool bigEndian, bool colourCounts, const std::string& keyword = "OFF", int vertexExtra = 0) {
  std::string text = keyword + " BINARY\n" + bytes(4, bigEndian) + bytes(4, bigEndian) + bytes(6, bigEndian);
  for (const auto& p : kCorners) {
    for (const float x : p) text += bytes(x, bigEndian);
    for (int i = 0; i < vertexExtra; ++i) text += bytes(0.5f, bigEndian);
  }
  for (std::size_t f = 0; f < kFaces.size(); ++f) {
    text += bytes(3, bigEndian);
    for (const int i : kFaces[f]) text += bytes(i, bigEndian);
    if (!colourCounts) continue;
    const int components = f % 2 ? 4 : 0;
    text += bytes(components, bigEndian);
    for (int i = 0; i < components; ++i) text += bytes(1.0f, bigEndian);
  }
  return text;
}

/// Whatever is missing at the end of a file, reading it must not succeed, nor do anything but complain.
void expectEveryTruncationComplains(const std::string& name, const std::string& content) {
  for (std::size_t size = 0; size < content.size(); ++size)
    EXPECT_NE(complaintAbout(name, content.substr(0, size)), "") << name << " cut at " << size;
}

TEST(MeshReadPly, TextAndBothByteOrdersAgree) {
  for (const std::string newline : {"\n", "\r\n"}) {
    expectClosed(readText("a.ply", plyHeader("format ascii 1.0", newline) + kPlyBody), 4, 1.0 / 6);
    expectClosed(readText("a.ply", plyBinary(false, newline)), 4, 1.0 / 6);
    expectClosed(readText("a.ply", plyBinary(true, newline)), 4, 1.0 / 6);
  }
  expectClosed(readText("a.ply", plyHeader("format ascii 1.0", "\r") + kPlyBody), 4, 1.0 / 6);
  expectClosed(readText("a.ply", plyBinary(false, "\r")), 4, 1.0 / 6);
}

TEST(MeshReadPly, DataMayStartWithANewlineByte) {
  // 0x0a0a0a0a as a float in the place of the first coordinate.
  std::string text = plyBinary(false);
  text.replace(text.find("end_header\n") + 11, 4, "\n\n\n\n");
  const Mesh mesh = readText("a.ply", text);
  EXPECT_FLOAT_EQ(static_cast<float>(mesh.positions[0][0]), std::bit_cast<float>(0x0a0a0a0a));
  EXPECT_EQ(mesh.positions[1], (Vec3d{1, 0, 0}));
}

TEST(MeshReadPly, AnyOrderOfPropertiesAndElements) {
  const Mesh mesh = readText(
      "a.ply", "ply\nformat ascii 1.0\nelement material 1\nproperty list uchar float shine\nelement face 1\n"
               "property uchar red\nproperty list uchar float uv\nproperty list ushort uint8 vertex_index\n"
               "property int flags\nelement vertex 4\nproperty double z\nproperty list uchar int neighbours\n"
               "property short y\nproperty float nx\nproperty float64 x\nend_header\n"
               "2 0.5 0.25\n255 2 nan 0.5 4 0 1 2 3 7\n0 1 9 0 nan 0\n0 0 0 nan 1\n0 0 1 nan 1\n0 0 1\n nan 0\n");
  EXPECT_EQ(mesh.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(checkMesh(mesh).area, 1);
}

TEST(MeshReadPly, StripsTurnEveryOtherTriangleAndRestart) {
  // A tetrahedron as one strip of four triangles, then a second strip that starts anew and a stitch without area.
  const std::string header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                             "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                             "0 0 0\n1 0 0\n0 1 0\n0 0 1\n5 5 5\n";
  const Mesh mesh = readText("a.ply", header + "6 1 0 2 3 1 0\n");
  expectClosed(mesh, 4, 1.0 / 6);
  const Mesh two = readText("a.ply", header + "11 0 1 2 -1 1 0 2 -1 2 2 3\n");
  EXPECT_EQ(two.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {1, 0, 2}}));
  EXPECT_NE(complaintAbout("a.ply", header + "3 0 1 5\n").find("a.ply:15: a face refers to vertex 5"),
            std::string::npos);
  EXPECT_NE(complaintAbout("a.ply", header + "3 0 1 -2\n"), "");
}

TEST(MeshReadPly, CountsAreCheckedBeforeAnythingIsAllocated) {
  RunContext ctx;
  ctx.memoryLimit = 1 << 20;
  std::string text = plyBinary(false);
  for (const std::string element : {"element vertex 4", "element face 4"}) {
    std::string lie = text;
    lie.insert(lie.find(element) + element.size(), "000000000000");
    EXPECT_NE(complaintAbout("a.ply", lie, ctx).find("more than the rest of the file can hold"), std::string::npos);
  }
  std::string list = text;
  list[list.find("end_header\n") + 11 + 48] = '\xff';
  EXPECT_NE(complaintAbout("a.ply", list, ctx).find("items does not fit"), std::string::npos);
  // A row without properties takes no bytes, so nothing bounds its count, and nothing may loop over it.
  expectClosed(readText("a.ply",
                        [&] {
                          std::string ghost = text;
                          return ghost.insert(ghost.find("element face"), "element ghost 18446744073709551615\n");
                        }()),
               4, 1.0 / 6);
}

TEST(MeshReadPly, ErrorsNameTheLine) {
  const std::string header = plyHeader("format ascii 1.0");
  const std::pair<std::string, std::string> cases[] = {
      {header + "0 0 0\n1 0 0\n0 1 x\n", "a.ply:"},
      {"ply\nformat ascii 1.0\nelement vertex x\n", "a.ply:3: element count 'x'"},
      {"ply\nformat text 1.0\n", "a.ply:2: format 'text'"},
      {"ply\nformat ascii 1.0\nproperty float x\n", "a.ply:3: a property before any element"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\n", "a.ply:4: unknown property type 'real'"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n", "a.ply:4: a list cannot be counted"},
      {"ply\nformat ascii 1.0\nelement vertex 4\nproper", "a.ply:4: the file ends within its header"},
      {"ply without an end", "a.ply:1: the file ends within its header"},
      {"ply\nelement vertex 4\nend_header\n", "a.ply:3: the header has no format line"},
      {"ply\nformat ascii 1.0\nelement face 4\nend_header\n", "a.ply: the header has no element 'vertex'"},
      {"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n", "a.ply: element 'vertex' needs"},
      {header + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 4\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
       "a.ply:15: a face refers to vertex 4"},
      {header + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n2 0 2\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
       "a.ply:15: a face needs three corners"},
      {header + "0 0 0\n1 inf 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
       "a.ply:12: 'inf' is not a finite"},
      {header, "a.ply:11: the header announces 4 rows of 'vertex'"},
      {"ply\nformat ascii 1.0\nend_header\n", "a.ply: the header announces no elements"}};
  for (const auto& [text, expected] : cases) {
    const std::string what = complaintAbout("a.ply", text);
    EXPECT_TRUE(what.starts_with(expected)) << what;
  }
}

TEST(MeshReadPly, TruncationAlwaysComplains) {
  expectEveryTruncationComplains("a.ply", plyBinary(false));
  const std::string text = plyHeader("format ascii 1.0") + kPlyBody;
  expectEveryTruncationComplains("a.ply", text.substr(0, text.size() - 1));
}

TEST(MeshReadPly, LeftOverDataAreWarnedOf) {
  std::string warning;
  RunContext ctx;
  ctx.onLog = [&](LogLevel, std::string_view line) { warning = line; };
  expectClosed(readText("a.ply", plyBinary(false) + "more", ctx), 4, 1.0 / 6);
  EXPECT_NE(warning.find("ignored"), std::string::npos);
}

TEST(MeshReadStl, CornersAreWelded) {
  for (const std::string& text : {stlBinary(), stlBinary("solid and yet binary"), stlText("a", 0)}) {
    const Mesh mesh = readText("a.stl", text);
    EXPECT_EQ(mesh.positions.size(), 4u);
    EXPECT_TRUE(mesh.groupNames.empty());
    expectClosed(mesh, 4, 1.0 / 6);
  }
  // -0 and 0 are the same place.
  std::string text = stlText("a", 0);
  text.replace(text.find("vertex 0.000000"), 15, "vertex -0.00000");
  EXPECT_EQ(readText("a.stl", text).positions.size(), 4u);
}

TEST(MeshReadStl, SolidsBecomeGroupsInAnyCase) {
  std::string second = stlText("Second Part", 2);
  for (const std::string word : {"solid", "facet", "vertex", "endloop"})
    for (std::size_t at = second.find(word); at != second.npos; at = second.find(word, at)) second[at] -= 'a' - 'A';
  const Mesh mesh = readText("a.stl", stlText("first", 0) + second);
  EXPECT_EQ(mesh.groupNames, (std::vector<std::string>{"first", "Second Part"}));
  EXPECT_EQ(mesh.triangleGroup, (std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(checkMesh(mesh).components, 2u);
}

TEST(MeshReadStl, DamageComplains) {
  const std::string text = stlText("a", 0);
  expectEveryTruncationComplains("a.stl", text.substr(0, text.find("endsolid") + 7));
  expectEveryTruncationComplains("a.stl", stlBinary());
  std::string more = stlBinary();
  more[80] = 5;
  EXPECT_NE(complaintAbout("a.stl", more).find("byte 80: announces 5 triangles but the file holds 4"),
            std::string::npos);
  std::string nan = stlBinary();
  nan.replace(84 + 12, 4, bytes(std::numeric_limits<float>::quiet_NaN()));
  EXPECT_NE(complaintAbout("a.stl", nan).find("not a finite number"), std::string::npos);
  EXPECT_TRUE(complaintAbout("a.stl", "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n"
                                      "endfacet\nendsolid\n")
                  .starts_with("a.stl:6: a facet has three vertices, this one has 2"));
  EXPECT_NE(complaintAbout("a.stl", "solid a\nendsolid a\n").find("holds no triangle"), std::string::npos);
}

TEST(MeshReadOff, CommentsColoursAndJammedCounts) {
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  const std::string coloured = "# colours\n\n0 0 0 1 0 0 1\n1 0 0 .5 .5 .5 1 # red\n0 1 0 0 0 0 0\n\n0 0 1 1 1 1 1\n"
                               "3 0 2 1 255 0 0\n3 0 1 3 0.5\n3 0 3 2\n  3 1 2 3 1 2 3 4\n";
  for (const std::string& text :
       {"OFF\n4 4 6\n" + body, "OFF 4 4 6\n" + body, " \tOFF4 4 0 # jammed\n" + body, "# c\nOFF\n# c\n4 4\n" + body,
        "COFF\n4 4 6\n" + coloured, "STCNOFF\r\n4 4 0\r\n" + coloured})
    expectClosed(readText("a.off", text), 4, 1.0 / 6);
  const std::pair<std::string, std::string> cases[] = {
      {"4OFF\n1 1 1\n", "a.off:1: only three-dimensional"},
      {"OFF\n353535235358 6 0\n" + body, "a.off:2: announces 353535235358 vertices"},
      {"OFF\n-1 6 0\n" + body, "a.off:2: announces -1 vertices"},
      {"OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 4\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
       "a.off:7: a face refers to vertex 4"},
      {"OFF\n4 5 0\n" + body, "a.off:11: the file ends"}};
  for (const auto& [text, expected] : cases) {
    const std::string what = complaintAbout("a.off", text);
    EXPECT_TRUE(what.starts_with(expected)) << what;
  }
}

TEST(MeshReadOff, BinaryInBothDialects) {
  for (const bool bigEndian : {true, false})
    for (const bool colourCounts : {true, false}) {
      expectClosed(readText("a.off", offBinary(bigEndian, colourCounts)), 4, 1.0 / 6);
      expectClosed(readText("a.off", offBinary(bigEndian, colourCounts, "CNOFF", 7)), 4, 1.0 / 6);
      expectEveryTruncationComplains("a.off", offBinary(bigEndian, colourCounts));
    }
}

} // namespace
} // namespace volcaustic::test
