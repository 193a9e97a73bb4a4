// One mesh file, several materials: from the scene file to the index in the medium.
#include "unit/mesh_support.h"
#include "volcaustic/openvdb.h"
#include "volcaustic/scene.h"
#include "volcaustic/session.h"

#include <gtest/gtest.h>

namespace volcaustic::test {
namespace {

/// Quads of a cube of half side r, outwards, as OBJ with the vertices from `first` on.
std::string cubeObj(double r, int first, const std::string& group) {
  std::ostringstream text;
  for (int i = 0; i < 8; ++i)
    text << "v " << (i & 1 ? r : -r) << " " << (i & 2 ? r : -r) << " " << (i & 4 ? r : -r) << "\n";
  text << group << "\n";
  for (const auto& [a, b, c, d] : std::initializer_list<std::array<int, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    text << "f " << a + first << " " << b + first << " " << c + first << " " << d + first << "\n";
  return text.str();
}

/// The index of a scene's medium at points of the x axis.
class GroupedScene {
public:
  GroupedScene(const std::string& obj, const std::string& objectKeys) {
    writeFile(mFolder / "goblet.obj", obj);
    const std::string text = R"({"volcaustic": 1, "voxelise": {"blur": 1},
      "volume": {"bounds": {"min": [-2, -2, -2], "max": [2, 2, 2]}, "resolution": 40},
      "materials": {"glass": {"index": 1.5}, "wine": {"index": 1.34}, "air": {"index": 1}},
      "objects": [{"name": "goblet", "mesh": "goblet.obj", "translate": [0.3, 0, 0])" +
                             objectKeys + "}]}";
    mSession.emplace(parseScene(text, mFolder / "scene.json"));
  }

  float indexAt(double x) {
    const MediumGrids& grids = mSession->medium().grids();
    const openvdb::Vec3d at = grids.index->worldToIndex(openvdb::Vec3d(x + 0.3, 0.05, 0.05));
    return grids.index->tree().getValue(openvdb::Coord::round(at));
  }
  Session& session() { return *mSession; }

private:
  TemporaryFolder mFolder;
  std::optional<Session> mSession;
};

TEST(MediumGroups, EveryGroupHasItsIndex) {
  const std::string obj =
      cubeObj(1.5, 1, "usemtl glass") + cubeObj(1, 9, "usemtl wine") + cubeObj(0.5, 17, "usemtl bubble");
  GroupedScene scene(obj, R"(, "groups": [{"name": "wine", "material": "wine", "priority": 1},
                                          {"name": "bubble", "material": "air", "priority": 2}])");
  EXPECT_FLOAT_EQ(scene.indexAt(0.05), 1.0f);
  EXPECT_FLOAT_EQ(scene.indexAt(0.75), 1.34f);
  EXPECT_FLOAT_EQ(scene.indexAt(1.25), 1.5f);
  EXPECT_FLOAT_EQ(scene.indexAt(1.65), 1.0f);

  // Without groups the three shells are a union.
  Scene plain = scene.session().scene();
  plain.objects[0].groups.clear();
  scene.session().setScene(plain);
  EXPECT_FLOAT_EQ(scene.indexAt(0.75), 1.5f) << "the medium is made anew when the groups change";
  EXPECT_FLOAT_EQ(scene.indexAt(0.05), 1.5f);
}

TEST(MediumGroups, PrioritiesCountFromTheObjects) {
  // The object's priority is above both groups' own numbers; of equal ones the group comes later.
  const std::string obj = cubeObj(1.5, 1, "o glass") + cubeObj(1, 9, "o wine");
  GroupedScene scene(obj, R"(, "priority": 7, "groups": [{"name": "wine", "material": "wine"}])");
  EXPECT_FLOAT_EQ(scene.indexAt(0.05), 1.34f);
  GroupedScene below(obj, R"(, "priority": 7, "groups": [{"name": "wine", "material": "wine", "priority": -1}])");
  EXPECT_FLOAT_EQ(below.indexAt(0.05), 1.5f);
}

TEST(MediumGroups, AGroupThatTheMeshDoesNotHaveIsAnErrorWithTheNearest) {
  GroupedScene scene(cubeObj(1, 1, "g wine"), R"(, "groups": [{"name": "wnie", "material": "wine"}])");
  try {
    scene.session().medium();
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "goblet: no group is called \"wnie\"; the nearest known one is \"wine\"");
    EXPECT_EQ(error.kind(), ErrorKind::Input);
  }
}

} // namespace
} // namespace volcaustic::test
